"""Debug views of voxel-cones (techniques/voxel_cones/views/views.py): what they say is what there is."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import scene_of
from test_voxel_cones import BRIGHTEST, DEPTH, GRID, WEIGHT, N, scene, seen, start, volume, voxels
from voxel_scenes import BYTE, grid_of, random_scene
from voxel_tools import built, mesh_of, random_triangles, read, shine

from octolux.frame.structs import MAX_VIEWS, VIEW
from octolux.frame.views import camera_view
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.scene.cameras import Camera
from octolux.scene.errors import OctoluxError
from octolux.simulator.voxels.cones import above, basis, diffuse_samples, trace
from octolux.simulator.voxels.directions import PHASES, directions
from octolux.simulator.voxels.fragments import fragments
from octolux.simulator.voxels.pyramid import facing_levels, intensity_levels
from octolux.simulator.voxels.starts import Plane, cone_start
from octolux.simulator.voxels.surfaces import DIRECTIONS
from octolux.techniques.voxel_cones.cones.wide import WideCones
from octolux.techniques.voxel_cones.views.contents import keys_of, level_voxels
from octolux.techniques.voxel_cones.views.drawing import NOTHING, Drawing, picture
from octolux.techniques.voxel_cones.views.fragment_list import FragmentList
from octolux.techniques.voxel_cones.views.pixel_cones import CONE_SAMPLE, PixelCones, drawn_over

TENTH_BITS = 0.5 / 1023  # of shares on coarse levels, which are made of rounded ones


def test_voxels_of_every_level(device):
    """What they face and send, against the dense pyramid; on level 0 also colours. Light has 9 bits of the brightest
    channel, and is made of rounded light and shares on each level anew."""
    grid, rng = grid_of(5), np.random.default_rng(3)
    made, expected = random_scene(grid, 200, 6.0, 41, emissive=(30.0, 5.0, 0.0))
    octree = built(device, made, grid, peak=30.0)
    light = 8.0 * rng.uniform(size=(*expected.facing.shape, 3)) * expected.facing[..., None]
    shine(octree, light, unit=8.0)
    facings = facing_levels(expected.facing)
    for level, (facing, sent) in enumerate(zip(facings, intensity_levels(light, facings), strict=True)):
        found = level_voxels(octree, level, 8.0)
        x, y, z = found["cell"].T
        there = np.zeros(facing.shape[:3], bool)
        there[z, y, x] = True
        assert not facing[~there].any() and len(np.unique(found["cell"], axis=0)) == len(found)
        np.testing.assert_allclose(found["facing"], facing[z, y, x], atol=BYTE + 30 / 8192 + (level + 1) * TENTH_BITS)
        np.testing.assert_allclose(found["light"], sent[z, y, x], atol=8.0 * 1e-2)
    found = level_voxels(octree, 0, 8.0)
    x, y, z = found["cell"].T
    dense = read(octree)
    np.testing.assert_allclose(found["albedo"], dense.albedo[z, y, x], atol=1e-6)
    np.testing.assert_allclose(found["emission"], 30.0 * dense.emission[z, y, x], rtol=1e-6)
    assert found["emission"].max() > 20.0 and found["light"].max() > 4.0


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("level", [0, 2])
def test_what_each_pixel_meets_first(device, level, perspective):
    """Against all cells' boxes cut by all rays, which may differ where a ray grazes an edge."""
    grid = grid_of(4)
    octree = built(device, random_scene(grid, 40, 5.0, 42)[0], grid)
    found = level_voxels(octree, level, 1.0)
    cells = found["cell"][found["facing"].any(axis=1)]
    edge = grid.cell_size * 2.0**level
    middle = np.array(grid.origin) + 0.5 * grid.n * grid.cell_size
    camera = Camera.look_at(middle + np.array([0.9, 0.7, 1.3]), middle, vertical_fov=0.9)
    camera = camera if perspective else Camera(transform=camera.transform, orthographic_height=1.2)
    view = camera_view(camera, 40, 30, 5.0)
    views = VIEW.array(MAX_VIEWS)
    packed = views[0] = view.pack()[0]
    frame = SimpleNamespace(pixels=(40, 30), buffers={"views": device.uniform("views", views)})
    met = Drawing(device, octree, level).met(frame)
    x, y = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    origin, towards = (
        packed[name] + x[..., None] * packed[f"{name}_dx"] + y[..., None] * packed[f"{name}_dy"]
        for name in ("origin", "direction")
    )
    low = np.array(grid.origin) + edge * cells
    with np.errstate(divide="ignore"):
        ends = np.stack([(low + side - origin[..., None, :]) / towards[..., None, :] for side in (0.0, edge)])
    enters, leaves = ends.min(axis=0), ends.max(axis=0).min(axis=-1)
    into = enters.max(axis=-1)
    cut = (into < leaves) & (leaves > 0.0)
    nearest = np.where(cut, into, np.inf).argmin(axis=-1)
    there = cut.any(axis=-1)
    axis = np.take_along_axis(enters, nearest[..., None, None], axis=2)[:, :, 0].argmax(axis=-1)
    assert 0.1 < there.mean() < 0.9
    same = np.where(there, keys_of(cells)[nearest], NOTHING) == met.key
    assert same.mean() > 0.99
    far = np.take_along_axis(into, nearest[..., None], axis=2)[..., 0] * np.linalg.norm(towards, axis=-1) / edge
    np.testing.assert_allclose(met.distance[there & same], far[there & same], rtol=1e-4, atol=1e-4)
    looks = -np.sign(np.take_along_axis(towards, axis[..., None], axis=-1)[..., 0])
    assert (DIRECTIONS[met.way][there & same, axis[there & same]] == looks[there & same]).mean() > 0.99
    shown = picture(met, cells, np.ones((len(cells), 3)))
    assert shown.dtype == np.float32 and np.array_equal(shown.any(axis=-1), met.key != NOTHING)


def test_the_list_of_fragments(device):
    """The same as the simulator's, in an order of its own."""
    grid = grid_of(5)
    corners = random_triangles(grid, 150, 7.0, 43)
    made = scene_of([mesh_of(corners)])
    octree, gpu_scene = built(device, made, grid), GpuScene(device)
    gpu_scene.sync(made)
    listed = FragmentList(device, octree.octree)
    found, expected = listed.list(gpu_scene, octree), fragments(corners, grid)
    inside = ((expected.voxel >= 0) & (expected.voxel < grid.n)).all(axis=1)
    order = np.lexsort((expected.share, *expected.voxel.T))
    order = order[inside[order]]
    mine = np.lexsort((found["share"], *found["voxel"].T))
    np.testing.assert_array_equal(found["voxel"][mine], expected.voxel[order])
    np.testing.assert_array_equal(found["share"][mine], expected.share[order].astype(np.float32))
    counts = [np.sort(np.unique(t, return_counts=True)[1]) for t in (found["triangle"], expected.triangle[inside])]
    np.testing.assert_array_equal(*counts)
    np.testing.assert_array_equal(listed.list(gpu_scene, octree), found)
    empty = built(device, scene_of([]), grid)
    nothing = GpuScene(device)
    nothing.sync(scene_of([]))
    assert len(FragmentList(device, empty.octree).list(nothing, empty)) == 0


WIDE, OPTIONS = WideCones(count=6, width=0.5), {"offset": 1.0, "cover": "surfaces", "resolution": 1}


def test_samples_of_a_pixels_cones(device):
    """Those that the simulator's cones take, up to where they have met enough; what they cover adds up to what
    diffuse cones do. The specular cone comes last."""
    made, at = PixelCones(device, voxels(), WIDE, step=0.5, glossy=True, **OPTIONS), start(device)
    for row, column in np.argwhere(at.inside)[:: at.inside.sum() // 6]:
        samples = made.samples(seen(device).frame, GRID, (column, row), **volume(device))
        normal, geometric = at.s.normals[row, column][None], at.s.geometric[row, column][None]
        phase = column % 4 + 4 * (row % 4)
        assert phase < PHASES and set(samples["cone"]) == set(range(7))
        for cone, axis in enumerate(directions(6, phase)):
            towards, noted = above(basis(normal) @ axis, geometric), []

            def reading(points, level, along, noted=noted):
                light, opacity = scene()(points, level, along)
                noted.append((points[0], float(np.ravel(level)[0]), light[0], opacity[0]))
                return light, opacity

            to_eye = at.s.to_eye[row, column][None]
            begin = cone_start(scene(), DEPTH, at.points[row, column][None], geometric, to_eye, 1.0)
            left = trace(
                reading, begin, towards, diffuse_samples(6, DEPTH, 2, 0.5), N,
                "surfaces", Plane(geometric, 1.0),
            ).left[0]  # fmt: skip
            of_cone = samples[samples["cone"] == cone]
            assert 3 < len(of_cone) <= len(noted)
            points, levels, light, opacity = (np.array(part[: len(of_cone)]) for part in zip(*noted, strict=True))
            np.testing.assert_allclose(of_cone["position"], points, atol=1e-4 * N)
            np.testing.assert_array_equal(of_cone["level"], levels)
            np.testing.assert_allclose(of_cone["towards"], np.repeat(towards, len(of_cone), axis=0), atol=1e-3)
            # Three ways are read, whose parts of a unit vector add up to at most sqrt(3).
            np.testing.assert_allclose(of_cone["light"], light, atol=np.sqrt(3.0) * WEIGHT * BRIGHTEST)
            np.testing.assert_allclose(of_cone["opacity"], opacity, atol=np.sqrt(3.0) * WEIGHT)
            assert abs(1.0 - of_cone["share"].sum() - left) <= 4.0 * WEIGHT
        tight = samples[samples["cone"] == 6]
        assert len(tight) and (tight["step"] <= 0.5).all() and tight["share"].sum() <= 1.0 + 1e-6


def test_pixels_without_cones(device):
    made, at = PixelCones(device, voxels(), WIDE, step=1.0, glossy=False, **OPTIONS), start(device)
    frame = seen(device).frame
    row, column = np.argwhere(~at.inside)[0]
    with pytest.raises(OctoluxError, match=f"{column}:{row} sees no surface in the voxels"):
        made.samples(frame, GRID, (int(column), int(row)), **volume(device))
    with pytest.raises(OctoluxError, match=f"Pixels are 0:0 to .*, not {frame.pixels[0]}:0"):
        made.samples(frame, GRID, (frame.pixels[0], 0), **volume(device))


def test_cones_are_drawn_where_they_are():
    """A disc as wide as its voxel, around where it lies, of its radiance; what lies behind the camera is not drawn."""
    camera = Camera.look_at((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), vertical_fov=2.0 * np.arctan(0.5))  # 4 m high there
    samples = np.zeros(2, CONE_SAMPLE.dtype)
    samples["position"] = [(20.0, 10.0, 0.0), (20.0, 10.0, 50.0)]
    samples["level"], samples["opacity"], samples["share"] = 3, 0.5, 1.0
    samples["light"] = (0.5, 0.25, 0.0)
    grid = octree_grid()
    shown = drawn_over(np.zeros((80, 80, 3), np.float32), samples, camera_view(camera, 80, 80, 9.0), grid, 1.0)
    np.testing.assert_allclose(shown[40, 60], (1.0, 0.5, 0.0), atol=1e-6)
    rows, columns = np.nonzero(shown.any(axis=-1))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (31, 48, 51, 68)  # 16 pixels wide, and the rim


def octree_grid():
    """Voxels of 0.1 m, of which (10, 10, 0) is the origin."""
    return type(GRID)((-1.0, -1.0, 0.0), 0.1, 64)
