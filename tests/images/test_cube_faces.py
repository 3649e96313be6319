"""A point light's six shadow maps meet without seams, and surfaces do not shadow themselves."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import material_of, random_directions, scene_of

from octolux.frame.frame import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, revolve
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.simulator import direct

LAMBERT = Material(base_color=(0.8, 0.8, 0.8), specular=0.0, double_sided=True)


def sphere(radius: float):
    angles = np.linspace(-np.pi / 2, np.pi / 2, 41)
    profile = np.stack([radius * np.cos(angles).clip(1e-4), radius * np.sin(angles)], axis=1)
    return revolve(profile, segments=80)


def unshadowed_ratio(picture, lights) -> tuple[np.ndarray, np.ndarray]:
    """Direct light over its closed form without shadows, and which pixels say something: lit at more than grazing
    angles on both the shading and the geometric normal."""
    position = picture.layers["position"].astype(np.float64)
    normal, albedo = picture.layers["normal"], material_of(picture)["base_color"]
    expected = sum(direct.lambert_radiance(light, position, normal, albedo) for light in lights)
    cosine = np.ones(position.shape[:2])
    for light in lights:
        to_light, _ = direct.incident(light, position)
        for n in (normal, picture.geometric_normal):
            cosine = np.minimum(cosine, (to_light * n).sum(axis=-1))
    sure = picture.mask & (cosine > 0.05) & (expected.max(axis=-1) > 0)
    return picture.layers["direct"][..., 0] / np.where(sure, expected[..., 0], 1), sure


def look_around(position=(0.0, 0.0, 0.0)) -> list[Camera]:
    """Six cameras of 100 degrees that together see everything around `position`."""
    position = np.asarray(position, float)
    ups = [(0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 0, 1), (0, 1, 0), (0, 1, 0)]
    forwards = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    return [Camera.look_at(position, position + f, up=u, vertical_fov=np.radians(100)) for f, u in
            zip(forwards, ups, strict=True)]  # fmt: skip


@pytest.mark.parametrize("resolution", [64, 512])
@pytest.mark.parametrize("shape", ["sphere", "box", "box off centre"])
def test_no_seams_between_faces_and_no_acne(device, shape, resolution):
    """Nothing stands between the light and the walls: every pixel within 2 % of the unshadowed closed form.

    But in a box's corners, within a shadow texel of the next wall: that wall's texels take part in the filter there and
    lie before the receiver's plane, as an occluder's would.
    """
    lamp = PointLight(position=(0.0, 0.0, 0.0), intensity=(10.0, 10.0, 10.0))
    mesh = sphere(2.0) if shape == "sphere" else box((-2, -2, -2), (2, 2, 2), inward=True)
    if shape == "box off centre":
        lamp = PointLight(position=(1.1, -0.7, 1.6), intensity=(10.0, 10.0, 10.0))
    settings = FrameSettings(shadow_resolution=resolution, rsm_resolution=64)
    renderer = Renderer(scene_of([mesh], [LAMBERT], lights=[lamp]), "none", size=(72, 72), device=device,
                        frame_settings=settings)  # fmt: skip
    for camera in look_around((0.1, 0.2, -0.1)):
        picture = renderer.render(camera)
        ratio, sure = unshadowed_ratio(picture, [lamp])
        if shape != "sphere":
            position = picture.layers["position"]
            away = np.abs(position - lamp.position)
            height = np.sum(away * np.abs(picture.layers["normal"]), axis=-1)
            texel = 2 * away.max(axis=-1) ** 2 / height / resolution  # longer on a wall seen at a slant
            sure &= np.sort(2 - np.abs(position), axis=-1)[..., 1] > 1.5 * texel
        assert sure.mean() > 0.6
        assert np.abs(ratio[sure] - 1).max() <= 0.02


@pytest.mark.parametrize("kind", ["spot", "directional"])
def test_no_acne_under_other_lights(device, kind):
    """A floor lit at every slant."""
    floor = box((-3, -0.1, -3), (3, 0, 3))
    for direction in random_directions(np.random.default_rng(1), 12):
        direction[1] = -abs(direction[1]) - 0.05
        light = DirectionalLight(direction=tuple(direction), illuminance=(1.0, 1.0, 1.0))
        if kind == "spot":
            place = tuple(-3 * direction / np.linalg.norm(direction))
            light = SpotLight(position=place, direction=tuple(direction), intensity=(1.0, 1.0, 1.0), outer_angle=0.5)
        settings = FrameSettings(shadow_resolution=128, rsm_resolution=64)
        scene = scene_of([floor], [LAMBERT], lights=[light])
        camera = Camera.look_at((0.0, 4.0, 0.1), (0.0, 0.0, 0.0))
        picture = Renderer(scene, "none", size=(48, 48), device=device, frame_settings=settings).render(camera)
        ratio, sure = unshadowed_ratio(picture, [light])
        assert sure.mean() > 0.02
        assert np.abs(ratio[sure] - 1).max() <= 0.02


def test_shadows_are_there(device):
    """A ball between lamp and floor: its shadow is black in the middle, and there is none away from it."""
    lamp = PointLight(position=(0.0, 2.0, 0.0), intensity=(10.0, 10.0, 10.0))
    floor = box((-3, -1.1, -3), (3, -1, 3))
    scene = scene_of([floor, sphere(0.4)], [LAMBERT], lights=[lamp])
    settings = FrameSettings(shadow_resolution=256, rsm_resolution=64)
    camera = Camera.look_at((0.0, 0.5, 5.0), (0.0, -1.0, 0.0))
    picture = Renderer(scene, "none", size=(96, 64), device=device, frame_settings=settings).render(camera)
    ratio, sure = unshadowed_ratio(picture, [lamp])
    on_floor = sure & (picture.layers["object_id"] == 1)
    across = np.hypot(picture.layers["position"][..., 0], picture.layers["position"][..., 2])
    # The cone around the ball: radius 3 tan(asin(0.4 / 2)) = 0.612 on the floor, 3 m below the lamp.
    umbra, lit = on_floor & (across < 0.58), on_floor & (across > 0.65)
    assert umbra.sum() > 30 and lit.sum() > 500
    assert ratio[umbra].max() == 0 and np.abs(ratio[lit] - 1).max() <= 0.02
