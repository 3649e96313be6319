"""Scenes with something missing, and the furnace."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame.frame import COPY, RENDER
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.daylight import sun as sun_light
from octolux.scene.daylight import to_sun
from octolux.scene.lights import DirectionalLight, ParticleLights, PointLight, SpotLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Environment, Scene
from octolux.techniques.baselines import ConstantSettings

TECHNIQUES = ("none", "constant", "uniform-lpv", "voxel-cones")
BACKGROUND = (0.25, 0.5, 2.0)
SKY = Environment(BACKGROUND)
LIGHTS = [
    PointLight(position=(0.0, 0.5, 0.5), intensity=(1.0, 1.0, 1.0)),
    SpotLight(position=(0.0, 0.5, 0.5), direction=(0.0, -1.0, 0.0), intensity=(1.0, 1.0, 1.0)),
    DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(1.0, 1.0, 1.0)),
]  # fmt: skip
WALL = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


def render(device, scene, technique="uniform-lpv", camera=None, size=(24, 16), **rest):
    """A picture without the default sun and sky; the surroundings and what glows are seen but light nothing."""
    settings = small_settings(sky_lights=0, emitter_lights=0)
    rest = {"default_light": False, **rest}
    renderer = Renderer(scene, technique, size=size, device=device, frame_settings=settings, **rest)
    return renderer.render(camera or front_camera())


def no_triangles() -> Mesh:
    shapes = {"positions": 3, "normals": 3, "uvs": 2, "tangents": 4}
    arrays = {name: np.zeros((0, width), np.float32) for name, width in shapes.items()}
    return Mesh(indices=np.zeros((0, 3), np.uint32), **arrays)


def is_background(picture) -> bool:
    return np.all(picture.radiance == np.float32(BACKGROUND)) and not picture.mask.any()


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("lights", [[], LIGHTS], ids=["dark", "lit"])
def test_a_scene_without_geometry(device, technique, lights):
    scene = Scene(environment=SKY, lights=list(lights), exposure=0.0)
    picture = render(device, scene, technique)
    assert is_background(picture)
    assert not any(picture.layers[name].any() for name in ("direct", "indirect", "albedo", "normal", "object_id"))


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_meshes_without_triangles_or_instances(device, technique):
    scene = Scene(meshes=[no_triangles(), quad(WALL)], materials=[Material()], instances=[Instance(0)],
                  environment=SKY, lights=list(LIGHTS), exposure=0.0)  # fmt: skip
    assert is_background(render(device, scene, technique))
    scene.instances.append(Instance(1))
    assert render(device, scene, technique).mask.any()


@pytest.mark.parametrize("technique", ["none", "uniform-lpv"])
def test_a_scene_without_lights_is_black(device, technique):
    picture = render(device, scene_of([quad(WALL)], environment=SKY), technique, camera=front_camera(4.0))
    assert picture.mask.any() and not picture.mask.all()
    assert not picture.radiance[picture.mask].any()
    assert np.all(picture.radiance[~picture.mask] == np.float32(BACKGROUND))


@pytest.mark.parametrize("camera", [
    Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 5.0)), Camera.look_at((0.0, 0.0, 900.0), (0.0, 9.0, 1000.0)),
    Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 5.0), orthographic_height=4.0),
], ids=["away", "far away", "orthographic"])  # fmt: skip
def test_a_camera_that_sees_nothing(device, camera):
    assert is_background(render(device, scene_of([quad(WALL)], environment=SKY, lights=list(LIGHTS)), camera=camera))


def test_a_scene_that_comes_and_goes(device):
    scene = Scene(environment=SKY, exposure=0.0)
    renderer = Renderer(scene, "uniform-lpv", size=(24, 24), device=device, frame_settings=small_settings())
    assert is_background(renderer.render(front_camera()))
    renderer.scene.meshes, renderer.scene.materials = [quad(WALL)], [Material()]
    renderer.scene.instances, renderer.scene.lights = [Instance(0)], list(LIGHTS)
    assert renderer.render(front_camera()).radiance[12, 12].max() > 0
    renderer.scene.instances = []
    assert is_background(renderer.render(front_camera()))


def test_a_flat_scene_has_a_volume(device):
    """A single quad has no depth, and a single point light above it lights it."""
    picture = render(device, scene_of([quad(WALL)], lights=LIGHTS[:1]))
    assert picture.mask.any() and np.isfinite(picture.radiance).all()


def test_furnace_glows_alike_everywhere(device):
    """The closed box is seen in every pixel; without indirect light its radiance is what it emits, 1 nit, exactly."""
    picture = render(device, load_scene("furnace"), "none", size=(64, 48), camera=load_scene("furnace").cameras[0])
    assert picture.mask.all()
    assert np.array_equal(picture.radiance, np.ones_like(picture.radiance))
    assert np.array_equal(picture.layers["emissive"], picture.radiance)
    np.testing.assert_allclose(picture.layers["albedo"], 0.5, atol=0.5 / 65535)


def test_furnace_in_equilibrium(device):
    """e / (1 - a) = 2 nits: with the irradiance of that, 2 pi, every pixel must come out at 1 + 0.5 / pi * 2 pi."""
    settings = ConstantSettings(red=2 * pi, green=2 * pi, blue=2 * pi)
    scene = load_scene("furnace")
    picture = render(device, scene, "constant", camera=scene.cameras[0], settings=settings)
    np.testing.assert_allclose(picture.radiance, 2.0, rtol=2e-5)  # the albedo has 16 bits


def test_constant_irradiance_of_each_channel(device):
    settings = ConstantSettings(red=1.0, green=2.0, blue=4.0)
    material = Material(base_color=(0.8, 0.4, 0.2), metallic=0.0, specular=0.0)
    scene = scene_of([box((-1, -1, -1), (1, 1, 1), inward=True)], [material])
    picture = render(device, scene, "constant", settings=settings, camera=Camera.look_at((0, 0, 0.5), (0, 0, -1)))
    expected = np.array([0.8, 0.4, 0.2]) / pi * [1.0, 2.0, 4.0]
    np.testing.assert_allclose(picture.radiance, np.broadcast_to(expected, picture.radiance.shape), rtol=5e-5)


def test_what_a_picture_lacks_is_said(device):
    renderer = Renderer(scene_of([]), "none", size=(8, 8), device=device)
    sunny, empty = renderer.warnings
    assert "the sun and the sky" in sunny and "no triangles" in empty
    renderer.default_light = False
    assert renderer.warnings == [empty]


def test_sun_and_sky_light_what_has_no_light(device):
    """Sunny side up: a floor is bright where nothing shines, and black without the default light."""
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    above = Camera.look_at((0.0, 3.0, 0.1), (0.0, 0.0, 0.0))
    assert not render(device, scene_of([floor]), "none", above).layers["direct"].any()
    picture = render(device, scene_of([floor]), "none", above, default_light=True)
    lit = sun_light()
    # White Lambert: E / pi from the sun alone, since sky_lights = 0; nothing stands in its way.
    expected = np.array(lit.illuminance) * to_sun()[1] / pi
    np.testing.assert_allclose(picture.radiance[picture.mask], np.tile(expected, (picture.mask.sum(), 1)), rtol=1e-4)
    assert picture.radiance[~picture.mask].min() > 0


@pytest.mark.parametrize("glowing", [Material(emissive=(1.0, 1.0, 1.0)), Material(unlit=True)], ids=["glows", "unlit"])
def test_what_shines_needs_no_sun(device, glowing):
    assert Renderer(scene_of([quad(WALL)], [glowing]), "none", size=(8, 8), device=device).warnings == []


@pytest.mark.parametrize("degrees", [0.5, 2.0, 20.0])
def test_a_spot_is_as_bright_on_its_axis_however_narrow(device, degrees):
    """The middle pixel of an odd picture lies on the axis of camera and spot alike, where the cone's ramp is 1."""

    def on_axis(outer: float) -> np.ndarray:
        spot = SpotLight(position=(0, 0, 2), direction=(0, 0, -1), intensity=(8, 8, 8), outer_angle=radians(outer))
        camera = Camera.look_at((0, 0, 2), (0, 0, 0), vertical_fov=radians(degrees))
        picture = render(device, scene_of([quad(WALL)], lights=[spot]), "none", camera, size=(33, 33))
        return picture.layers["direct"][16, 16]

    wide = on_axis(45.0)
    assert wide.min() > 0
    # float32 tells the axis from 1 to 6e-8, of the 3.8e-5 that the narrowest ramp spans, and the ramp is squared.
    np.testing.assert_allclose(on_axis(degrees), wide, rtol=2 * 2 * 6e-8 / 3.8e-5)


def test_pictures_larger_than_a_buffer_are_read_in_strips(device):
    """4200 x 4200 texels of 16 bytes are more than the 256 MiB a buffer may have."""
    texture = device.texture("large", (4200, 4200), "rgba32float", usage=COPY | RENDER)
    encoder = device.wgpu.create_command_encoder()
    attachment = {"view": texture.create_view(), "load_op": "clear", "store_op": "store", "clear_value": (1, 2, 3, 4)}
    encoder.begin_render_pass(color_attachments=[attachment]).end()
    device.queue.submit([encoder.finish()])
    read = device.read_texture(texture, np.float32, 4)
    assert read.shape == (4200, 4200, 4) and (read == (1, 2, 3, 4)).all()


def test_techniques_without_particle_lights_say_so(device):
    lights = [ParticleLights(positions=np.zeros((2000, 3)), intensities=(1, 1, 1))]
    renderer = Renderer(scene_of([quad(WALL)], lights=lights), "uniform-lpv", size=(8, 8), device=device)
    assert renderer.warnings == ["2,000 particle lights are left out: uniform-lpv takes none"]
    assert not renderer.render(front_camera()).radiance.any()
    assert Renderer(renderer.scene, "path-tracer", size=(8, 8), device=device).warnings == []
