"""Camera rays and direct light against an independent path tracer (Mitsuba 3); skipped without its pictures."""

import json

import numpy as np
import pytest

from octolux.data import data_folder
from octolux.scene.cameras import Camera
from octolux.scene.lights import PointLight
from octolux.simulator import camera, direct

FOLDER = data_folder() / "ground-truth"
SINGLE = 2.0**-24
"""Relative rounding of the stored float32 values."""


def load(name: str) -> tuple[dict, dict]:
    if not (FOLDER / f"{name}.npz").exists():
        pytest.skip(f"no ground truth in {FOLDER}")
    return json.loads((FOLDER / f"{name}.json").read_text()), dict(np.load(FOLDER / f"{name}.npz"))


def scene_camera(described: dict) -> Camera:
    return Camera.look_at(
        described["look_from"], described["look_at"], described["up"], vertical_fov=np.radians(described["vfov_deg"])
    )


@pytest.mark.parametrize("name", ["cornell_point", "sponza_sunpoint"])
def test_pixel_rays_hit_what_the_path_tracer_saw(name):
    """A wrong convention is off by half a pixel or more; float32 positions by much less than 1/100."""
    described, pictures = load(name)
    seen = pictures["mask"].astype(bool)
    eye = scene_camera(described["camera"])
    origins, directions = camera.pixel_rays(eye, described["width"], described["height"])
    towards = (pictures["position"] - origins)[seen]
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    pixel = 2.0 * np.tan(0.5 * eye.vertical_fov) / described["height"]
    assert np.linalg.norm(towards - directions[seen], axis=-1).max() < 0.01 * pixel


def test_direct_light_of_a_lambertian_box():
    """Lit pixels of the Cornell box under a point light of 1 cd. Positions are rounded at 2 m, which the inverse square
    and the cosine turn into four times that over the distance; a dozen float32 operations come on top."""
    described, pictures = load("cornell_point")
    light = PointLight(position=tuple(described["lights"][0]["position"]), intensity=(1.0, 1.0, 1.0))
    lit = pictures["mask"].astype(bool) & (pictures["direct"].sum(axis=-1) > 0)
    position, normal, albedo = (pictures[key][lit].astype(np.float64) for key in ("position", "normal", "albedo"))
    found = direct.lambert_radiance(light, position, normal, albedo)
    to_light = np.asarray(light.position) - position
    height = np.sum(to_light * normal, axis=-1)
    tolerance = SINGLE * (12 + 4 * 2.0 / height)
    np.testing.assert_array_less(np.abs(found / pictures["direct"][lit] - 1.0).max(axis=-1), tolerance)
