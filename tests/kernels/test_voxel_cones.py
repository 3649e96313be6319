"""Cones on the device (techniques/voxel_cones/cones/gathering.py) against the simulator's."""

from __future__ import annotations

from functools import cache
from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import wgpu
from gpu_tools import TESTS, one_stage
from test_glossy import HALF_FLOAT, lobe_albedo, seen
from test_gtao import rendered

import octolux
from octolux.gpu.bindings import sampler, texture
from octolux.scene.default_camera import chosen_camera
from octolux.scene.errors import OctoluxError
from octolux.simulator.grid import Grid
from octolux.simulator.voxels.cones import gather, specular_light
from octolux.simulator.voxels.directions import PHASES, phases_of
from octolux.simulator.voxels.facing import FacingVoxels
from octolux.simulator.voxels.filtering import filtered
from octolux.techniques.voxel_cones.cones.diffuse import DiffuseCones
from octolux.techniques.voxel_cones.cones.gathering import Voxels
from octolux.techniques.voxel_cones.cones.specular import SpecularCones
from octolux.techniques.voxel_cones.cones.wide import WideCones

DEPTH, N = 4, 16
GRID = Grid((-1.05, -1.1, -1.0), 0.135, N)
BRIGHTEST = 3.0
# A texture unit may round each of the three weights of a trilinear sample to 1/256: of what differs between voxels, up
# to 1 of opacity and BRIGHTEST of radiance, it is off by 3/512.
WEIGHT = 3.0 / 512 + HALF_FLOAT


@cache
def scene() -> FacingVoxels:
    rng = np.random.default_rng(2)
    facing = rng.random((N, N, N, 6)) * (rng.random((N, N, N, 1)) < 0.08)
    facing = facing.astype(np.float16).astype(np.float64)
    return FacingVoxels(facing, facing[..., None] * rng.uniform(0.2, BRIGHTEST, (N, N, N, 6, 3)))


@cache
def volume(device, given: FacingVoxels | None = None) -> dict[str, Any]:
    """Texture and sampler of dense_voxels.wgsl; of `scene` by default."""
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    made = device.texture("made by a test", (6 * N, N, N), "rgba16float", usage=usage, mip_levels=DEPTH, dimension="3d")
    for number, (facing, intensity) in enumerate((given or scene()).levels):
        n = len(facing)
        texels = np.moveaxis(np.concatenate([intensity, facing[..., None]], axis=-1), 3, 2)
        data = np.ascontiguousarray(texels.reshape(n, n, 6 * n, 4).astype(np.float16))
        layout = {"bytes_per_row": 48 * n, "rows_per_image": n}
        device.queue.write_texture({"texture": made, "mip_level": number}, data, layout, (6 * n, n, n))
    linear = device.wgpu.create_sampler(
        mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
    )
    return {"facing_volume": made, "facing_sampler": linear}


def voxels(skips: bool = False) -> Voxels:
    bindings = [texture("facing_volume", "float", "3d"), sampler("facing_sampler")]
    return Voxels(DEPTH, str(TESTS / "kernels" / "dense_voxels.wgsl"), bindings, skips=skips)


def start(device) -> SimpleNamespace:
    """Where the G-buffer's pixels see something, in voxels, and which see it in the cube: empty pixels have the
    camera's place, which is outside."""
    s = seen(device)
    points = GRID.to_cells(s.points)
    return SimpleNamespace(s=s, points=points, inside=((points > 0.0) & (points < N)).all(axis=-1))


def traced(device, made: DiffuseCones) -> np.ndarray:
    """Raw irradiance and visibility (height, width, 4)."""
    frame = seen(device).frame
    made.prepare(frame.pixels)
    with one_stage(device) as stage:
        made.gather(stage, frame, GRID, **volume(device))
        made.filter(stage, frame)
    return device.read_texture(made.raw[0], np.float32, 4).astype(np.float64)


@pytest.mark.parametrize(
    ("count", "per_level", "width", "cover"),
    [(8, 2, 1.0, "surfaces"), (5, 3, 0.5, "medium"), (16, 1, 1.0, "surfaces")],
)
def test_diffuse_as_the_simulator(device, count, per_level, width, cover):
    """Each cone's samples add up to a share of at most 1, and what they are off by does, too."""
    options = {"count": count, "per_level": per_level, "width": width}
    found = traced(device, DiffuseCones(device, voxels(), WideCones(**options), cover=cover))
    at = start(device)
    rows, columns = np.nonzero(at.inside)
    phase = columns % 4 + 4 * (rows % 4)
    assert at.inside.sum() > 250 and len(np.unique(phase)) == PHASES
    for i in range(PHASES):
        r = (rows[phase == i], columns[phase == i])
        light, visible = gather(
            scene(), DEPTH, at.points[r], at.s.normals[r], at.s.geometric[r], phases=[i], cover=cover,
            to_eye=at.s.to_eye[r], **options,
        )  # fmt: skip
        assert np.abs(found[r][:, :3] - light).max() <= 4.0 * WEIGHT * pi * BRIGHTEST
        assert np.abs(found[r][:, 3] - visible).max() <= 4.0 * WEIGHT
    nothing = ~at.inside
    assert np.array_equal(found[nothing], np.tile([0.0, 0.0, 0.0, 1.0], (nothing.sum(), 1)))


def test_air_as_the_simulator(device):
    """Light that the air takes from what cones find, and ambient visibility within a reach."""
    edge, (absorbed, reach) = GRID.cell_size, (0.2, 5.0)
    found = traced(device, DiffuseCones(device, voxels(), attenuation=absorbed / edge, reach=reach * edge))
    clear, at = traced(device, DiffuseCones(device, voxels())), start(device)
    rows, columns = np.nonzero(at.inside)
    phase = columns % 4 + 4 * (rows % 4)
    for i in range(0, PHASES, 5):
        r = (rows[phase == i], columns[phase == i])
        light, visible = gather(
            scene(), DEPTH, at.points[r], at.s.normals[r], at.s.geometric[r], phases=[i], absorbed=absorbed,
            air_reach=reach, to_eye=at.s.to_eye[r],
        )  # fmt: skip
        assert np.abs(found[r][:, :3] - light).max() <= 4.0 * WEIGHT * pi * BRIGHTEST
        assert np.abs(found[r][:, 3] - visible).max() <= 4.0 * WEIGHT
    assert found[at.inside][:, :3].mean() < 0.8 * clear[at.inside][:, :3].mean()
    assert found[at.inside][:, 3].mean() > clear[at.inside][:, 3].mean() + 0.05


@pytest.mark.parametrize("absorbed", [0.0, 0.15])
def test_specular_as_the_simulator(device, absorbed):
    made, at = SpecularCones(device, voxels(), attenuation=absorbed / GRID.cell_size), start(device)
    found = reflected(device, made)[at.inside]
    s = at.s
    _, cone = specular_light(
        scene(), DEPTH, at.points[at.inside], s.normals[at.inside], s.geometric[at.inside], s.to_eye[at.inside],
        s.material.roughness[at.inside], absorbed=absorbed,
    )  # fmt: skip
    albedo = lobe_albedo(s)[at.inside]
    error = np.abs(found - albedo * cone.radiance) / albedo.max()
    assert np.percentile(error, 99) <= 4.0 * WEIGHT * BRIGHTEST
    assert np.mean(found) > 0.05


def test_empty_cells_are_skipped_without_a_trace(device):
    """Other samples fall on what is there: the tents add up to the same, but for where cones begin and end."""
    plain, skipped = (reflected(device, SpecularCones(device, voxels(skips), step=0.25)) for skips in (False, True))
    assert not np.array_equal(plain, skipped)
    assert np.abs(plain - skipped).mean() <= 0.02 * plain.mean()


def reflected(device, made: SpecularCones) -> np.ndarray:
    frame = seen(device).frame
    made.prepare(frame.pixels)
    with one_stage(device) as stage:
        made.run(stage, frame, GRID, **volume(device))
    return device.read_texture(made.specular, np.float32, 4)[..., :3].astype(np.float64)


@pytest.fixture(scope="module")
def atrium(device) -> SimpleNamespace:
    """Columns, edges, normal maps; and a cube around all that is seen, with a hair of room for rounding."""
    scene = octolux.load("atrium")
    made = rendered(device, scene, chosen_camera(scene, None, 96 / 54))
    low, high = (np.array(side) + hair for side, hair in zip(scene.bounds(), (-1e-3, 1e-3), strict=True))
    made.grid = Grid(tuple(low), float(np.max(high - low)) / N, N)
    return made


@pytest.mark.parametrize("tile", [1, 2])
def test_pixels_of_small_tiles_have_several_sets(device, tile):
    """All pixels of a tile together have each phase once."""
    found, at = traced(device, DiffuseCones(device, voxels(), WideCones(count=4, tile=tile))), start(device)
    assert sorted(phase for i in np.ndindex(tile, tile) for phase in phases_of(*i, tile)) == list(range(PHASES))
    for row, column in np.argwhere(at.inside)[::23]:
        r = (np.array([row]), np.array([column]))
        light, visible = gather(
            scene(), DEPTH, at.points[r], at.s.normals[r], at.s.geometric[r], phases=phases_of(row, column, tile),
            count=4, to_eye=at.s.to_eye[r],
        )  # fmt: skip
        assert np.abs(found[r][:, :3] - light).max() <= 4.0 * WEIGHT * pi * BRIGHTEST
        assert np.abs(found[r][:, 3] - visible).max() <= 4.0 * WEIGHT


@pytest.mark.parametrize(("tile", "among"), [(2, 4), (1, 8)])
def test_samples_have_all_sets_between_them(device, tile, among):
    """Their mean is what all sets bring; sums are of another order."""
    whole, at = traced(device, DiffuseCones(device, voxels(), WideCones(count=4, tile=tile))), start(device)
    frame, found = seen(device).frame, []
    made = DiffuseCones(device, voxels(), WideCones(count=4, tile=tile, among=among))
    try:
        for frame.sample in range(among):
            found.append(traced(device, made))
    finally:
        frame.sample = 0
    np.testing.assert_allclose(np.mean(found, axis=0)[at.inside], whole[at.inside], atol=64 * 2.0**-24 * BRIGHTEST * pi)
    assert not np.allclose(found[0], found[1], atol=0.01)


@pytest.mark.parametrize(("resolution", "tile"), [(1, 4), (2, 4), (4, 4), (1, 2), (2, 1)])
def test_filter_as_the_simulator(device, atrium, resolution, tile):
    """From the device's own raw picture. Normals are the same bits on both sides; heights over a pixel's plane are
    known within 2^-20 of the depth, and count in widths of a raw pixel; a weight's change moves the mean by at most as
    much for each of sixteen."""
    made = DiffuseCones(device, voxels(), WideCones(tile=tile), resolution=resolution)
    made.prepare(atrium.frame.pixels)
    with one_stage(device) as stage:
        made.gather(stage, atrium.frame, atrium.grid, **volume(device))
        made.filter(stage, atrium.frame)
    raw, place = (device.read_texture(t, np.float32, 4).astype(np.float64) for t in made.raw)
    expected = filtered(atrium.seen, raw, place, resolution, tile)
    wide = resolution * np.linalg.norm(atrium.seen.pixel_extent()[0], axis=-1)
    there = atrium.seen.depth > 0.0
    most = 16.0 * 2.0**-20 * (atrium.seen.depth / wide)[there].max() * raw.max() + 1e-5
    irradiance = device.read_texture(made.irradiance, np.float32, 4)
    assert np.abs(irradiance[..., :3] - expected[..., :3])[there].max() <= most
    visibility = device.read_texture(made.visibility, np.float32, 1)[..., 0]
    assert np.abs(visibility - expected[..., 3])[there].max() <= most
    assert np.all(irradiance[..., 3] == 1.0) and np.all(visibility[~there] == 1.0)
    assert np.std(expected[there]) > 0.01


@cache
def even() -> FacingVoxels:
    """Light of one radiance, everywhere and from everywhere."""
    facing = np.ones((N, N, N, 6))
    return FacingVoxels(facing, facing[..., None] * [2.0, 1.0, 0.5])


@pytest.mark.parametrize("resolution", [2, 4])
def test_even_light_is_reflected_alike_at_all_resolutions(device, atrium, resolution):
    """Each pixel has its own albedo; of what is around it nothing but the light is taken."""
    found = []
    for made in (SpecularCones(device, voxels()), SpecularCones(device, voxels(), resolution=resolution)):
        made.prepare(atrium.frame.pixels)
        with one_stage(device) as stage:
            made.run(stage, atrium.frame, atrium.grid, **volume(device, even()))
        found.append(device.read_texture(made.specular, np.float32, 4)[..., :3])
    lit = found[0].max(axis=-1) > 0.0
    assert lit.mean() > 0.5
    assert np.abs(found[1] - found[0])[lit].max() <= WEIGHT * found[0].max()


def test_the_same_bits_again(device):
    made = DiffuseCones(device, voxels(), resolution=2)
    first, again = traced(device, made), traced(device, made)
    assert np.array_equal(first, again)


@pytest.mark.parametrize(
    "wrong", [{"resolution": 3}, {"cover": "walls"}, {"offset": -1.0}, {"attenuation": -1.0}, {"reach": -1.0}]
)
def test_wrong_values(device, wrong):
    with pytest.raises(OctoluxError, match=r"not"):
        DiffuseCones(device, voxels(), **wrong)


@pytest.mark.parametrize(
    "wrong",
    [
        {"count": 3}, {"width": 0.0}, {"per_level": 9}, {"tile": 3}, {"screen": -1.0}, {"screen": 65.0},
        {"among": 2}, {"tile": 2, "among": 3}, {"tile": 1, "among": 0},
    ],
)  # fmt: skip
def test_wrong_cones(wrong):
    with pytest.raises(OctoluxError, match=r"not"):
        WideCones(**wrong)
