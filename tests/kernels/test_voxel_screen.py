"""Cones that are followed on the screen first, against the simulator's (simulator/voxels/screen.py)."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage
from test_gtao import rendered
from test_lookup import picture_texture
from test_voxel_cones import BRIGHTEST, DEPTH, WEIGHT, N, scene, volume, voxels

import octolux
from octolux.scene.cameras import Camera
from octolux.scene.default_camera import chosen_camera
from octolux.simulator.grid import Grid
from octolux.simulator.voxels.cones import gather
from octolux.simulator.voxels.directions import phases_of
from octolux.simulator.voxels.screen import CLEARANCE, Shown, ceiling, screen_way
from octolux.techniques.voxel_cones.cones.diffuse import DiffuseCones
from octolux.techniques.voxel_cones.cones.wide import WideCones
from octolux.techniques.voxel_cones.views.pixel_cones import PixelCones

SIZE = (48, 32)
# Pixels and metres within which the device's float32 may find another answer: a picture some 2^6 pixels wide and a room
# of 2^2 metres, ten roundings of 2^-24 each; the depth is a float32 too.
UNSURE = np.array([2.0**6, 2.0**2]) * 10.0 * 2.0**-24


@pytest.fixture(scope="module", params=["perspective", "orthographic", "double-sided"])
def room(request, device) -> SimpleNamespace:
    """The Cornell box in the middle of a cube of random voxels, whose surfaces reflect random light. Its walls' backs
    are looked through, but where all is double-sided: there ways go as far as the picture does."""
    box = octolux.load("cornell-box")
    if request.param == "double-sided":
        box = replace(box, materials=[replace(material, double_sided=True) for material in box.materials])
    flat = Camera.look_at((0.3, 1.5, 3.5), (0.0, 0.9, 0.0), orthographic_height=2.4)
    made = rendered(device, box, flat if request.param == "orthographic" else chosen_camera(box, None, 1.5), SIZE)
    made.light = np.random.default_rng(4).uniform(0.0, BRIGHTEST, (SIZE[1], SIZE[0], 4)).astype(np.float32)
    made.frame.targets.direct_diffuse = picture_texture(device, made.light, "rgba32float")
    low, high = box.bounds()
    edge = 1.1 * float(np.max(high - low)) / N
    made.grid = Grid(tuple(0.5 * (low + high) - 0.5 * N * edge), edge, N)
    made.albedo = made.picture.layers["albedo"].astype(np.float64)
    return made


def expected(room, wide: WideCones, pixels: np.ndarray, phases, **options) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Irradiance and visibility of pixels (m, 2) that have one phase, and which of them are sure."""
    at, seen, margin = tuple(pixels.T), room.seen, []
    points, geometric = seen.positions()[at], seen.geometric[at]
    rays = seen.rays()[1]
    to_eye = -rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    highest = ceiling(room.frame.gpu_scene.culls) * room.grid.cell_size

    def shown(towards, shift) -> Shown:
        start = points + CLEARANCE * room.grid.cell_size * geometric
        way = screen_way(seen, start, room.grid.cell_size * towards, wide.screen, shift, highest)
        margin.append(way.margin)
        there = tuple(np.maximum(way.pixel, 0).T)
        return Shown(way.met, way.free, room.light[there][:, :3].astype(np.float64), room.albedo[there])

    light, visible = gather(
        scene(), DEPTH, room.grid.to_cells(points), seen.normal[at], geometric, count=wide.count, phases=phases,
        per_level=wide.per_level, width=wide.width, screen=shown, bounces=wide.bounces,
        to_eye=to_eye[at], **options,
    )  # fmt: skip
    return light, visible, (np.array(margin) > UNSURE).all(axis=(0, 2))


@pytest.mark.parametrize(("bounces", "absorbed", "reach"), [(1, 0.0, 0.0), (3, 0.3, 2.0)])
def test_as_the_simulator(device, room, bounces, absorbed, reach):
    """Where no step is so near to another answer that rounding could bring it: of what is met the light is exact, and
    each reflection brings as much of the error again."""
    edge, wide = room.grid.cell_size, WideCones(count=4, screen=6.0, bounces=bounces)
    made = DiffuseCones(device, voxels(), wide, attenuation=absorbed / edge, reach=reach * edge)
    found, sure_of = gathered(device, made, room), 0
    options = {"absorbed": absorbed, **({"air_reach": reach} if reach else {})}
    voxels_alone = DiffuseCones(device, voxels(), replace(wide, screen=0.0), attenuation=absorbed / edge)
    assert not np.allclose(gathered(device, voxels_alone, room), found, atol=0.1)
    there = np.argwhere(room.seen.depth > 0.0)
    for row, column in np.ndindex(4, 4):
        pixels = there[(there[:, 0] % 4 == row) & (there[:, 1] % 4 == column)]
        light, visible, sure = expected(room, wide, pixels, phases_of(row, column, 4), **options)
        r = tuple(pixels[sure].T)
        sure_of += sure.sum()
        assert np.abs(found[r][:, :3] - light[sure]).max() <= bounces * 4.0 * WEIGHT * np.pi * BRIGHTEST
        assert np.abs(found[r][:, 3] - visible[sure]).max() <= 4.0 * WEIGHT
    assert sure_of > 0.9 * len(there)


def gathered(device, made: DiffuseCones, room) -> np.ndarray:
    made.prepare(room.frame.pixels)
    with one_stage(device) as stage:
        made.gather(stage, room.frame, room.grid, **volume(device))
    return device.read_texture(made.raw[0], np.float32, 4).astype(np.float64)


def test_what_a_cone_meets_on_the_screen_is_its_only_sample(device, room):
    """Of the debug view: at the end of its way, of the radiance there, for all of the cone."""
    wide = WideCones(count=4, screen=6.0)
    made = PixelCones(device, voxels(), wide, resolution=1, offset=1.0, cover="surfaces", step=1.0, glossy=False)
    corner = np.argwhere(room.seen.depth > 0.0)[::13]
    met = 0
    for row, column in corner:
        samples = made.samples(room.frame, room.grid, (int(column), int(row)), **volume(device))
        for cone in range(wide.count):
            of_cone = samples[samples["cone"] == cone]
            if len(of_cone) == 1 and of_cone["opacity"] == 1.0:
                met += 1
                assert of_cone["share"] == 1.0
                assert (np.abs(room.light[..., :3] - of_cone["light"]).max(axis=-1) < 1e-6).any()
    assert met > 10
