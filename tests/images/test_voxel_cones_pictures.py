"""voxel-cones as pictures: what voxels send is what lights bring, closed forms, what moves, presets."""

from __future__ import annotations

import sys
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gpu_tools import read_buffer, scene_of, small_settings

from octolux.frame.structs import VPL
from octolux.gpu.device import Device
from octolux.gpu.profiler import Profiler
from octolux.gpu.records import read_records
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.scene import Scene
from octolux.simulator.gtao import LEAST_WEIGHT
from octolux.techniques import TECHNIQUES
from octolux.techniques.voxel_cones.bricks.representation import REPRESENTATIONS
from octolux.techniques.voxel_cones.technique import VoxelCones

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # benchmarks is not installed

from benchmarks.vct_closed_forms import beam
from benchmarks.vct_scene import PRESETS, from_above

SIZE = (32, 24)
ALBEDO = (0.6, 0.3, 0.1)
PAINT = Material(base_color=ALBEDO, specular=0.0)
FLOOR = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])


def renderer(device, scene: Scene, preset: str = "default", size=SIZE, **settings) -> Renderer:
    return Renderer(
        scene, "voxel-cones", preset=preset, settings={"depth": 6, "bounces": 1, **settings}, size=size, device=device,
        exposure=0.0,
        anti_aliasing="off", default_light=False, frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


def technique(made: Renderer) -> VoxelCones:
    assert isinstance(made.technique, VoxelCones)
    return made.technique


def sent(made: VoxelCones, normal: np.ndarray) -> np.ndarray:
    """Flux that voxels of level 0 send, lm or W (3,), if each holds surfaces of one normal n: F n / (pi edge^2) each
    way (inject.wgsl)."""
    octree, bricks = made.octree, made.octree.bricks
    first, count = bricks.levels[0]
    words = read_buffer(octree.device, bricks.light.resource, np.uint32)[8 * first : 8 * (first + count)]
    owners = read_buffer(octree.device, bricks.owners.resource, np.uint32)[first : first + count]
    codes = words[:, None] >> np.array([0, 9, 18], np.uint32) & 511
    light = codes * 2.0 ** ((words >> 27).astype(np.float64)[:, None] - 40.0)
    ways = np.zeros((octree.octree.counts.nodes, 8, 6, 3))
    ways[owners >> 3, :, owners & 7] = light.reshape(count, 8, 3)
    to_flux = pi * octree.grid.cell_size**2 * made.injection.unit
    if octree.bricks.representation.directed:  # the first brick's light is the sum of what goes each way
        return to_flux * (ways[:, :, 0] / np.abs(normal).sum()).sum(axis=(0, 1))
    return to_flux * np.sqrt((ways**2).sum(axis=2)).sum(axis=(0, 1))


class Noting(VoxelCones):
    """Keeps what it was given."""

    given: Any = None

    def update(self, frame) -> None:
        type(self).given = frame
        super().update(frame)


LIGHTS = [
    [DirectionalLight(direction=(0.3, -1.0, 0.1), illuminance=(5.0, 6.0, 7.0))],
    [PointLight(position=(0.2, 1.0, 0.3), intensity=(5.0, 6.0, 7.0))],
    [DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(5.0, 6.0, 7.0)),
     SpotLight(position=(0.2, 1.0, 0.3), direction=(0.0, -1.0, 0.0), intensity=(5.0, 6.0, 7.0))],
]  # fmt: skip


@pytest.mark.parametrize("lights", LIGHTS)
@pytest.mark.parametrize("kept", REPRESENTATIONS)
def test_voxels_send_what_the_lights_bring(device, monkeypatch, lights, kept):
    """All flux of the VPLs, whatever the normal. What voxels send has 9 bits, so is off by up to 2^-9 of the largest
    channel of a voxel; and at the rim, which is slanted, columns with no sample, less than 1/8 covered, have none."""
    monkeypatch.setitem(TECHNIQUES, "voxel-cones", Noting)
    tilted = quad([(-1, -0.3, 1), (1, 0.5, 0.8), (1, 0.3, -1), (-1, -0.5, -0.8)])
    scene = scene_of([tilted], [replace(PAINT, double_sided=True)], lights=lights)
    made = renderer(device, scene, resolution=1, representation=kept)
    made.render(from_above(3.0, 2.0))
    frame = Noting.given
    vpls = read_records(device, frame.vpls, VPL, sum(count for _, count in frame.vpl_ranges))
    brought = vpls["flux"].astype(np.float64).sum(axis=0)
    assert (brought > 0.0).all()
    rim = 2 * (1 / 61 + 1 / 55) * 1 / 8 * 1 / 8  # of 61 x 55 voxels
    normal = np.cross((2.0, 0.8, -0.2), (0.0, -0.2, -1.8))  # of two of its edges
    found = sent(technique(made), normal / np.linalg.norm(normal))
    np.testing.assert_allclose(found, brought, rtol=0.0, atol=(2.0**-9 + rim) * brought.max())


@pytest.mark.parametrize("preset", [*PRESETS, "default,representation=lobes"])
def test_a_beam_on_a_wall_lights_what_faces_it(device, preset):
    """A ceiling that is lit straight from below; 15 % is what is asked of cones."""
    np.testing.assert_allclose(beam(device, preset), 1.0, rtol=0.15)


def test_backs_are_lit_as_for_paths(device):
    """The same ceiling, single-sided and looking up."""
    np.testing.assert_allclose(beam(device, "default", up=True), 1.0, rtol=0.15)
    assert not beam(device, "default,interior=false", up=True).any()


def spot(x: float) -> SpotLight:
    return SpotLight(position=(x, 0.5, 0.0), direction=(0.0, -1.0, 0.0), intensity=(5.0, 6.0, 7.0), outer_angle=0.3)


@pytest.mark.parametrize("kept", REPRESENTATIONS)
def test_a_light_that_moves_touches_little(device, kept):
    """The picture is that of a fresh renderer, which filters everything, to the bit."""
    scene, camera = scene_of([FLOOR], [PAINT], lights=[spot(-0.5)]), from_above(2.0, 2.0)
    made = renderer(device, scene, depth=7, representation=kept)
    before = made.render(camera)
    made.scene = replace(scene, lights=[spot(-0.45)])
    after = made.render(camera)
    octree = technique(made).octree
    updated = int(read_buffer(device, octree.filtering.updates.count, np.uint32)[0])
    assert 0 < updated <= 0.4 * octree.bricks.bricks.used
    fresh = renderer(device, made.scene, depth=7, representation=kept).render(camera)
    assert np.array_equal(after.radiance, fresh.radiance)
    made.scene = scene
    assert np.array_equal(made.render(camera).radiance, before.radiance)
    technique(made).forget()
    made.render(camera)
    assert read_buffer(device, octree.filtering.updates.count, np.uint32)[0] == 0, "what stays is not touched"


@pytest.mark.parametrize(("bounces", "kept"), [(1, "axial"), (3, "axial"), (3, "lobes")])
def test_lights_that_come_and_go(device, bounces, kept):
    """Frames are those of a fresh renderer: no light is left."""
    scene = load_scene("cornell-box")
    lamp = PointLight(position=(0.2, 1.2, 0.3), intensity=(5.0, 6.0, 7.0))
    made, pictures = renderer(device, scene, bounces=bounces, representation=kept), []
    for lights in ([lamp], [], [lamp, spot(0.1)], [lamp]):
        made.scene = replace(scene, lights=lights)
        pictures.append(made.render())
    first, dark, _, last = pictures
    assert first.layers["indirect"].any() and not dark.layers["indirect"].any()
    assert np.array_equal(first.radiance, last.radiance)


@pytest.mark.parametrize("kept", REPRESENTATIONS)
def test_bounces_add_light_but_create_none(device, kept):
    """Each brings more, and all together no more than a geometric series of the largest albedo would."""
    scene, counts = load_scene("cornell-box"), [(1, False), (2, False), (4, False), (4, True)]
    made = [renderer(device, scene, bounces=n, endless=on, representation=kept) for n, on in counts]
    means = [one.render().layers["indirect"].mean() for one in made]
    most = max(max(m.base_color) for m in scene.materials)
    assert means[0] * 1.1 < means[1] < means[0] * (1.0 + most)
    assert means[1] * 1.1 < means[2] < means[0] * (1.0 - most**4) / (1.0 - most)
    assert means[2] * 1.03 < means[3] < means[0] / (1.0 - most)


@pytest.mark.parametrize("albedo", [0.4, 0.8])
def test_endless_bounces_in_a_grey_room(device, albedo):
    """In a closed cube with a lamp in its middle walls receive indirectly a / (1 - a) of its flux, whatever its shape,
    and of four bounces a + ... + a^4. Each is within 5 %, as the white furnace is asked to be. A picture along an axis
    shows each part of a wall once."""
    room = scene_of([box((-1, -1, -1), (1, 1, 1), inward=True)], [Material(base_color=(albedo,) * 3, specular=0.0)],
                    lights=[PointLight(position=(0.0, 0.0, 0.0), intensity=(3.0, 2.0, 1.0))])  # fmt: skip
    inside = Camera.look_at((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), vertical_fov=0.5 * np.pi)
    flux = 4.0 * np.pi * np.array([3.0, 2.0, 1.0]) / 24.0
    powers = np.arange(1, 5)
    for endless in (True, False):
        made = renderer(device, room, bounces=4, endless=endless, size=(24, 24))
        found = made.render(inside).layers["irradiance"].mean(axis=(0, 1)) / flux
        least, most = (a / (1.0 - a) if endless else (a**powers).sum() for a in (0.95 * albedo, 1.05 * albedo))
        assert (found >= least).all() and (found <= most).all()


@pytest.mark.parametrize("preset", PRESETS)
def test_presets(device, preset):
    picture = renderer(device, load_scene("cornell-box"), preset).render()
    assert picture.layers["indirect"].any() and np.isfinite(picture.radiance).all()


def test_glossy_surfaces_reflect_the_voxels(device):
    scene = load_scene("cornell-box")
    shiny = replace(scene, materials=[replace(m, specular=1.0, roughness=0.1) for m in scene.materials])
    with_it, without = (renderer(device, shiny, glossy=on).render().layers["indirect"] for on in (True, False))
    assert with_it.mean() > 1.01 * without.mean()


def test_reflections_at_fewer_pixels(device):
    """Pixels that gather have what they have when all do, but for LEAST_WEIGHT of each of three others; those between
    have other light."""
    scene = load_scene("cornell-box")
    shiny = replace(scene, materials=[replace(m, specular=1.0, roughness=0.5) for m in scene.materials])
    every, half = (renderer(device, shiny, glossy_resolution=n).render().layers["specular"] for n in (1, 2))
    np.testing.assert_allclose(half[1::2, 1::2], every[1::2, 1::2], atol=3.0 * LEAST_WEIGHT * every.max())
    assert not np.allclose(half[::2, ::2], every[::2, ::2], rtol=0.01)


def test_memory_does_not_grow():
    scene, device = load_scene("cornell-box"), Device()  # of others, things may be collected meanwhile
    made, held = renderer(device, scene, size=(16, 12), bounces=2), []
    for k in range(10):
        lamps = [replace(spot(0.1), position=(0.5 * np.cos(k + i), 1.0, 0.0)) for i in range(3 - k % 3)]
        made.scene = replace(scene, lights=lamps)
        made.render()
        held.append(device.memory.total)
    assert held[4:7] == held[7:10]


def test_light_is_made_anew_only_when_it_changes(device):
    """Frames in which neither lights nor the scene are other than before inject nothing, and have the same bits as one
    that does; those in which a light or the paint is, do."""
    scene = replace(load_scene("cornell-box"), lights=[spot(0.1)])
    made, stages = renderer(device, scene, bounces=3), []
    made.profiler = Profiler(device, "fenced")

    def drawn() -> np.ndarray:
        picture = made.render()
        stages.append("injection" in made.profiler.last_frame())
        return picture.layers["irradiance"]

    first, kept = drawn(), drawn()
    technique(made).forget()
    again = drawn()
    made.scene = replace(scene, lights=[spot(0.2)])
    lit = drawn()
    made.scene = replace(made.scene, materials=[replace(m, base_color=(0.1, 0.5, 0.5)) for m in scene.materials])
    painted = drawn()
    assert stages == [True, False, True, True, True]
    np.testing.assert_array_equal(kept, first)
    np.testing.assert_array_equal(again, first)
    assert (lit != first).any() and (painted != lit).any()


def test_a_medium_that_changes_dims_what_reflects(device):
    """Air that changes under lights that stay: frames are a fresh renderer's."""
    scene = load_scene("cornell-box")
    made, means = renderer(device, scene), []
    for absorbed in (0.5, 2.0):
        medium = Medium(absorption=(absorbed,) * 3)
        made.scene = replace(scene, medium=medium)
        irradiance = made.render().layers["irradiance"]
        fresh = renderer(device, made.scene).render()
        np.testing.assert_array_equal(irradiance, fresh.layers["irradiance"])
        means.append(float(irradiance.mean()))
    assert means[0] > means[1] > 0.0
