"""What a scene gets that has no light, no camera and no exposure: a clear day, a view of all, a mean of middle grey."""

from __future__ import annotations

from math import exp, pi, radians, sin, tan

import numpy as np
import pytest
from gpu_tools import scene_of

from octolux.scene import daylight
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.default_camera import default_camera
from octolux.scene.exposure import MIDDLE_GREY, display_exposure, metered_exposure
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import environment as reference
from octolux.simulator import tonemap

SINE = sin(radians(50.0))  # of the sun's elevation


def horizontal_illuminance() -> np.ndarray:
    """Of the default sky's map on the ground, without the sun."""
    image = daylight.sky().image
    size = image.shape[:2]
    power = image * reference.texel_solid_angles(*size)[..., None]
    return (power * np.maximum(reference.texel_directions(*size)[..., 1:2], 0.0)).sum(axis=(0, 1))


def test_sky_illuminance_is_the_handbooks():
    """0.8 klx + 15.5 klx sqrt(sin h). Here with exact solid angles; where the map was made, sin(polar) at the texels'
    centres stood for them, which is too much by h^2 / 24 for texels of an edge of h = pi / 128, in all rows alike."""
    expected = 800.0 + 15500.0 * SINE**0.5
    found = horizontal_illuminance() @ reference.LUMINANCE
    # Colours have 7 digits, and Rec. 709's luminance 4, beside the 7 of the matrix from XYZ.
    assert found == pytest.approx(expected, rel=(pi / 128) ** 2 / 24 + 2e-4)


def test_sun_is_the_handbooks():
    light = daylight.sun()
    assert np.dot(light.illuminance, reference.LUMINANCE) == pytest.approx(127.5e3 * exp(-0.21 / SINE), rel=2e-4)
    np.testing.assert_allclose(np.array(light.direction), -daylight.to_sun(), atol=1e-15)
    assert light.direction[1] == pytest.approx(-SINE) and np.linalg.norm(light.direction) == pytest.approx(1.0)


def test_sky_is_brightest_around_the_sun_and_the_ground_even():
    sky = daylight.sky()
    assert sky.image.shape == (128, 256, 3) and not sky.is_black
    luminance = sky.image @ reference.LUMINANCE
    brightest = np.unravel_index(luminance.argmax(), luminance.shape)
    towards = reference.texel_directions(128, 256)[brightest]
    assert np.arccos(towards @ daylight.to_sun()) <= 2 * pi / 128  # within two texels
    ground = sky.image[64:].reshape(-1, 3)
    assert np.array_equal(ground, np.broadcast_to(ground[0], ground.shape))
    # Albedo 0.2 under sun and sky: E 0.2 / pi.
    total = horizontal_illuminance() + np.array(daylight.sun().illuminance) * SINE
    np.testing.assert_allclose(ground[0], 0.2 / pi * total, rtol=(pi / 128) ** 2 / 24 + 1e-5)
    assert (sky.image >= 0).all()


def test_daylight_of_6504_kelvin_is_white():
    """D65: its x is on the locus to the digits of the locus' formula, 4; a difference of 1e-4 in x or y changes a
    channel of Rec. 709 by at most 12e-4 (the largest row sum of the matrix, 5.2, over y, 0.33, times the change)."""
    color = daylight.daylight_color(6504.0)
    np.testing.assert_allclose(color, 1.0, atol=5.2 / 0.329 * 1e-4 * 2)
    assert color @ reference.LUMINANCE == pytest.approx(1.0, abs=2e-4)


def test_daylight_turns_from_red_to_blue():
    temperatures = np.linspace(4000.0, 25000.0, 50)
    colors = np.array([daylight.daylight_color(t) for t in temperatures])
    ratio = colors[:, 2] / colors[:, 0]
    assert (np.diff(ratio) > 0).all()
    assert ratio[0] < 1 < ratio[-1]
    # The locus' two formulas meet at 7000 K, to their four digits.
    np.testing.assert_allclose(daylight.daylight_color(7000.0), daylight.daylight_color(7000.1), atol=2e-3)


@pytest.mark.parametrize("luminance", [1e-6, 0.3, 4000.0, 1e9])
def test_a_mean_is_shown_as_middle_grey(luminance):
    ev100 = display_exposure(luminance)
    assert luminance * tonemap.exposure_factor(ev100) == pytest.approx(MIDDLE_GREY, rel=1e-12)
    # 0.8 stops brighter than a meter's: log2(1.2 * 0.18 * 100 / 12.5).
    assert metered_exposure(luminance) - ev100 == pytest.approx(np.log2(1.2 * 0.18 * 8.0), abs=1e-9)
    assert tonemap.display(np.full(3, luminance), ev100, "none")[0] == 118


@pytest.mark.parametrize("luminance", [0.0, -1.0, float("nan")])
def test_no_exposure_of_black(luminance):
    with pytest.raises(ValueError, match="must be positive"):
        display_exposure(luminance)


def placed(mesh, *transforms) -> Scene:
    return scene_of([mesh], instances=[Instance(0, t) for t in transforms])


CUBE = box((-1, -1, -1), (1, 1, 1))
FAR = np.diag([1.0, 1.0, 1.0, 1.0])
FAR[:3, 3] = (500.0, -3.0, 20.0)
SCENES = {
    "cube": placed(CUBE, np.eye(4)),
    "far cubes": placed(CUBE, np.eye(4), FAR),
    "tall": placed(CUBE, np.diag([0.1, 40.0, 0.1, 1.0])),
    "deep": placed(CUBE, np.diag([0.1, 0.1, 40.0, 1.0])),
    "flat": placed(quad([(-3, 0, 2), (3, 0, 2), (3, 0, -2), (-3, 0, -2)]), np.eye(4)),
    "tiny": placed(CUBE, np.diag([1e-5, 1e-5, 1e-5, 1.0])),
}


@pytest.mark.parametrize("aspect", [0.4, 1.0, 16 / 9, 4.0])
@pytest.mark.parametrize("name", SCENES)
def test_default_camera_holds_everything(name, aspect):
    """Every corner of the box lies before the near plane and within 85 % of the picture, and one reaches that."""
    scene = SCENES[name]
    camera = default_camera(scene, aspect)
    low, high = scene.bounds()
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    x, y, z = ((corners - camera.position) @ camera.transform[:3, :3]).T
    assert (-z >= camera.near).all()
    reach = np.maximum(np.abs(x) / aspect, np.abs(y)) / (-z * tan(camera.vertical_fov / 2))
    assert reach.max() == pytest.approx(0.85, rel=1e-9)


def test_default_camera_of_a_point_and_of_nothing():
    for scene in (Scene(), placed(CUBE, np.diag([0.0, 0.0, 0.0, 1.0]))):
        camera = default_camera(scene)
        ahead = -(scene.bounds()[0] - camera.position) @ camera.transform[:3, 2]
        assert np.isfinite(camera.transform).all() and ahead > camera.near > 0
