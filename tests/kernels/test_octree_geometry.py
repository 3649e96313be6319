"""The geometry volume on the device against the simulator's, and a wall seen. Its planes: test_octree_planes.py."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, scene_of, small_settings

from octolux.frame.peeling import LampLayer
from octolux.frame.structs import VPL
from octolux.gpu.records import record_texture
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.materials import Material
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import geometry as reference
from octolux.simulator.lpv.octree import level_sizes
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.geometry import GeometryVolume, fixed_point_wall
from octolux.techniques.lpv.injection import RUN
from octolux.techniques.lpv.levels import Levels

N = 16
GRID = Grid((-1.0, -0.5, 2.0), 0.25, N)
LEVELS = Levels(level_sizes(N))


def random_surfels(rng, count: int, area: float) -> np.ndarray:
    """In and around the grid, none within 0.01 cells of a face, where float32 and float64 may choose other cells; every
    seventh texel meets nothing."""
    vpls = VPL.array(count)
    vpls["normal"] = pack_normals(random_directions(rng, count))
    cells = rng.integers(-2, N + 2, (count, 3)) + rng.uniform(0.01, 0.99, (count, 3))
    vpls["position"] = GRID.origin + GRID.cell_size * cells
    vpls["area"] = rng.uniform(0.0, area, count)
    vpls["area"][3::7] = 0.0
    return vpls


def surfels_of(vpls: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, Grid]:
    """As the simulator takes them."""
    return vpls["position"].astype(np.float64), unpack_normals(vpls["normal"]), vpls["area"].astype(np.float64), GRID


def inject(vpls: np.ndarray) -> reference.Planes:
    return reference.inject_planes(*surfels_of(vpls))


def blocked_levels(groups: list[np.ndarray], planes: bool) -> list[np.ndarray]:
    """The simulator's, of several buffers."""
    if planes:
        return [level.shares for level in reference.plane_levels(reference.merge_planes([inject(g) for g in groups]))]
    volumes = [reference.inject_surfels(*surfels_of(g)) for g in groups]
    return reference.geometry_levels(reference.merge_buffers(volumes))


def run(
    device, made: GeometryVolume, groups: list[np.ndarray], lamps: int | None = None, width: int = 1,
    further: Sequence[list[np.ndarray]] = (),
) -> list[np.ndarray]:  # fmt: skip
    """Shares [z][y][x][3] of all levels; a group is a light's VPLs in rows of `width`, and the first `lamps` lights
    count. further: groups of the lights' further layers, of the same sizes."""
    starts = np.cumsum([0, *(len(g) for g in groups)])

    def texture(groups: list[np.ndarray]):
        vpls = VPL.array(max(1, int(starts[-1])))
        for start, group in zip(starts, groups, strict=False):
            vpls[start : start + len(group)] = group
        return record_texture(device, "vpls", VPL, len(vpls), vpls)

    frame = SimpleNamespace(
        vpls=texture(groups), vpl_surfaces=None, lamp_layers=[LampLayer(texture(layer), None) for layer in further],
        lights=SimpleNamespace(lamps=len(groups) if lamps is None else lamps),
        vpl_ranges=[(int(s), len(g)) for s, g in zip(starts, groups, strict=False)], vpl_widths=[width] * len(groups),
    )  # fmt: skip
    with one_stage(device) as stage:
        made.run(stage, frame, device.uniform("grid", pack_grid(GRID)))
    return made.blocked()


@pytest.fixture(scope="module", params=[False, True], ids=["shares", "planes"])
def made(device, request):
    return GeometryVolume(device, LEVELS, camera=False, planes=request.param)


def has_planes(made: GeometryVolume) -> bool:
    return "offsets" in made.volume


def test_surfels_of_three_lights(device, made):
    """Of all lights the most counts. Sums err by half a step of fixed point for each surfel, and by 1e-5 for normals
    and areas in float32."""
    rng = np.random.default_rng(1)
    groups = [random_surfels(rng, count, 0.1) for count in (20000, 3000, 1)]
    found = run(device, made, groups)
    expected = blocked_levels(groups, has_planes(made))
    most = max(np.bincount(cell_numbers(g)).max() for g in groups)
    for f, e in zip(found, expected, strict=True):
        np.testing.assert_allclose(f, e, rtol=1e-5, atol=most * 0.5 / 65536)
    assert 0.05 < (found[0] == 1.0).mean() < 0.95


def test_layers_of_a_light_are_summed(device, made):
    """As if they were one buffer's, and of all lights the most counts."""
    rng = np.random.default_rng(11)
    first, second, third = ([random_surfels(rng, count, 0.05) for count in (9000, 4000)] for _ in range(3))
    found = run(device, made, first, further=[second, third])
    together = [np.concatenate(layers) for layers in zip(first, second, third, strict=True)]
    most = max(np.bincount(cell_numbers(g)).max() for g in together)
    for f, e in zip(found, blocked_levels(together, has_planes(made)), strict=True):
        np.testing.assert_allclose(f, e, rtol=1e-5, atol=most * 0.5 / 65536)
    assert np.any(found[0] > np.maximum(*(run(device, made, layer)[0] for layer in (first, second))))


def cell_numbers(vpls: np.ndarray) -> np.ndarray:
    cells = np.clip(GRID.cell_of(vpls["position"].astype(np.float64)), 0, N - 1)
    return np.ravel_multi_index(cells.T, (N, N, N))


@pytest.mark.parametrize("width", [3, 64, 1000, 5000])
def test_any_width_of_the_map_gives_the_same_bits(device, made, width):
    """Texels that are below one another share cells, or do not; rows are whole, or are not."""
    rng = np.random.default_rng(6)
    surfels = random_surfels(rng, 20001, 0.1)
    surfels = surfels[np.argsort(cell_numbers(surfels), kind="stable")]
    plain, found = run(device, made, [surfels]), run(device, made, [surfels], width=width)
    assert all(np.array_equal(a, b) for a, b in zip(plain, found, strict=True))
    assert 0.05 < (found[0] == 1.0).mean() < 0.95


def test_frames_are_independent(device, made):
    """Nothing is left of a frame with more surfels and more lights."""
    rng = np.random.default_rng(2)
    few = [random_surfels(rng, 500, 0.1)]
    first = run(device, made, few)
    run(device, made, [random_surfels(rng, 9000, 0.3) for _ in range(3)])
    again = run(device, made, few)
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True)) and first[0].any()


def test_soft_lights_do_not_count(device, made):
    groups = [random_surfels(np.random.default_rng(seed), 500, 0.1) for seed in (3, 4)]
    one, two = run(device, made, groups[:1]), run(device, made, groups, lamps=1)
    assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))
    assert not any(level.any() for level in run(device, made, groups, lamps=0))


@pytest.mark.parametrize("count", [1, 1000, 1 << 17, 6 << 20, 1 << 26])
def test_a_wall_in_fixed_point(count):
    """All of a buffer stay below 2^42, so that 10 bits count how often a sum has gone beyond 32; a walk stays below
    that. It is as fine as float32 for some 200,000 surfels, and never coarser than without planes."""
    wall = fixed_point_wall(count, True)
    assert count * wall < 2**42 and RUN * wall < 2**32 and wall == 2 ** (wall.bit_length() - 1)
    assert wall == 2**24 if count <= 1 << 17 else wall >= fixed_point_wall(count, False) // 2


def test_a_cell_with_too_much_is_closed(device, made):
    """A hundred thousand large surfels in a cell: fixed point does not overflow."""
    found = run(device, made, [too_many(1e3)])[0]
    assert found[5, 5, 5, 2] == 1.0 and np.count_nonzero(found[..., 2]) == 1


def too_many(area: float, facing: int = 1) -> np.ndarray:
    """A hundred thousand surfels in one cell, a quarter of them at 0.3 in it, the others at 0.7.

    facing: along z, or against it."""
    vpls = VPL.array(100_000)
    vpls["normal"], vpls["area"] = pack_normals(np.array([0.0, 0.0, facing])), area
    vpls["position"] = np.array(GRID.origin) + 5.7 * GRID.cell_size
    vpls["position"][::4, 2] -= 0.4 * GRID.cell_size
    return vpls


# A wall of 2 x 2 m. What lies behind it, hidden, keeps it off the faces of the cells in the middle of the volume.
WALL = quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
HIDDEN = quad([(-0.1, -0.1, -0.1), (0.1, -0.1, -0.1), (0.1, 0.1, -0.1), (-0.1, 0.1, -0.1)])
IN_FRONT = Camera.look_at((0.0, 0.0, 1.5), (0.0, 0.0, 0.0), vertical_fov=2 * np.arctan(1.1 / 1.5))
LIGHTS = {
    "point": PointLight(position=(0.0, 0.0, 1.5), intensity=(1.0, 1.0, 1.0)),
    "sun": DirectionalLight(direction=(0.1, -0.2, -1.0), illuminance=(1.0, 1.0, 1.0)),
}


def wall_shares(device, lights, *, camera: bool, view=IN_FRONT) -> np.ndarray:
    """Share across z of the cells of level 0 in which the wall lies; no others are blocked."""
    scene = scene_of([WALL, HIDDEN], [Material(double_sided=True)], lights=lights)
    renderer = Renderer(
        scene, "octree-lpv", settings={"n": N, "surfels": "lamps and camera" if camera else "lamps"}, size=(256, 256),
        device=device,
        frame_settings=small_settings(shadow_resolution=256, rsm_resolution=256), default_light=False, exposure=0.0,
    )  # fmt: skip
    renderer.render(view)
    blocked = renderer.technique.debug_views()["blocked"][0]
    layer = renderer.technique.grid.cell_of([0.0, 0.0, 0.0])[2]
    assert not np.delete(blocked, layer, axis=0).any()
    assert blocked[..., :2].max() <= 0.01  # normals have 12 bits in the G-buffer and 16 in an RSM
    assert (blocked[layer, ..., 2] > 0.5).sum() == (N - 2) ** 2  # the default volume has a cell around the scene
    return blocked[layer, 1:-1, 1:-1, 2]


@pytest.mark.parametrize("names", [["point"], ["sun"], ["camera"], ["point", "sun", "camera"]], ids=" ".join)
def test_a_wall_in_a_picture(device, names):
    """Shares of about 1, however many buffers have seen it: not their sum. A cell is 12 texels wide for the point light
    (90 degrees, 256 texels over 3 m) and more for the others; those that lie in it are one row less at worst at either
    end of each direction."""
    shares = wall_shares(device, [LIGHTS[n] for n in names if n in LIGHTS], camera="camera" in names)
    assert shares.max() <= 1.0 and shares.min() > (1 - 2 / 12) ** 2 and shares.mean() > 1 - 2 / 12


@pytest.mark.parametrize("height", [None, 3.0], ids=["perspective", "orthographic"])
def test_a_wall_seen_from_aside(device, height):
    """Areas grow with distance and slant. A cell (1/7 m) is at least 8 pixels wide: 256 pixels over 3 m, or 2.5 m away
    152 / 2.5 a metre, seen at an angle of 0.85 of its width."""
    view = Camera.look_at((0.9, 0.3, 1.5), (0.0, 0.0, 0.0), vertical_fov=1.4, orthographic_height=height)
    shares = wall_shares(device, [], camera=True, view=view)
    assert shares.max() <= 1.0 and shares.min() > (1 - 2 / 8) ** 2 and shares.mean() > 1 - 2 / 8


def test_what_the_camera_does_not_see_does_not_count(device):
    scene = scene_of([WALL], [Material(double_sided=True)], lights=[])
    renderer = Renderer(scene, "octree-lpv", settings={"n": N, "surfels": "lamps and camera"}, size=(32, 32),
                        device=device, exposure=0.0, frame_settings=small_settings(), default_light=False)  # fmt: skip
    renderer.render(Camera.look_at((0.0, 0.0, 1.5), (0.0, 0.0, 3.0)))
    assert not any(level.any() for level in renderer.technique.debug_views()["blocked"])
