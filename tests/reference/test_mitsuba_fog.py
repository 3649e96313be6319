"""Fog beside Mitsuba's volumetric path tracer: light that is scattered once, past what stands in its way."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from gpu_tools import scene_of, small_settings
from mitsuba_tools import as_dict, mi

from octolux.export.files import FileFolder
from octolux.export.mitsuba import mitsuba_description
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.scene import Scene

LOW, HIGH = (-2.0, -1.5, -4.0), (2.0, 1.5, 0.0)
MEDIUM = Medium(scattering=(0.1, 0.2, 0.4), absorption=(0.1, 0.0, 0.1), low=LOW, high=HIGH)
EYE = Camera.look_at((0.4, 0.3, 2.0), (0.0, 0.0, -2.0))
BLOCKS, BATCHES, SAMPLES = (12, 8), 16, 512
# Lamps stand above the medium: in it, light at the lamp has no bound, and noise no end.
LIGHTS = {
    "sun": DirectionalLight(direction=(0.4, -1.0, -0.2), illuminance=(3.0, 2.0, 1.0)),
    "lamp": PointLight(position=(0.5, 2.2, -1.5), intensity=(3.0, 2.0, 1.0)),
    "spot": SpotLight(position=(-0.5, 2.2, -1.0), direction=(0.2, -1.0, -0.6), intensity=(9.0, 6.0, 3.0),
                      inner_angle=0.2, outer_angle=0.8),
}  # fmt: skip


def scene(light) -> Scene:
    """A black wall behind the medium, and in it a plate that takes light from the air below."""
    wall = quad([(-9, -9, -5), (9, -9, -5), (9, 9, -5), (-9, 9, -5)])
    plate = quad([(-1, 0.5, -1), (0.6, 0.5, -1), (0.6, 0.5, -3), (-1, 0.5, -3)])
    black = Material(base_color=(0, 0, 0), specular=0.0, double_sided=True)
    return scene_of([wall, plate], [black], lights=[light])


def traced(of: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Means of blocks of the picture and their standard errors, (rows, columns, 3)."""
    with tempfile.TemporaryDirectory() as folder:
        place = np.diag([2.0, 1.5, 2.0, 1.0])  # a cube is 2 wide
        place[2, 3] = -2.0
        description = mitsuba_description(of, EYE, BLOCKS, FileFolder(Path(folder) / "files"), exact=False)
        extinction = MEDIUM.extinction
        description["air"] = {
            "type": "cube", "to_world": place, "bsdf": {"type": "null"},
            "interior": {
                "type": "homogeneous", "sigma_t": {"type": "rgb", "value": extinction.tolist()},
                "albedo": {"type": "rgb", "value": (np.array(MEDIUM.scattering) / extinction).tolist()},
            },
        }  # fmt: skip
        description["integrator"] = {"type": "volpathmis", "max_depth": 2, "rr_depth": 99}
        made = mi.load_dict(as_dict(description, Path(folder)))
    batches = np.array([np.array(mi.render(made, spp=SAMPLES, seed=seed))[..., :3] for seed in range(BATCHES)])
    return batches.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(BATCHES)


@pytest.mark.parametrize("name", LIGHTS)
def test_single_scattering(device, name):
    of = scene(LIGHTS[name])
    wanted, error = traced(of)
    size = tuple(16 * n for n in BLOCKS)
    renderer = Renderer(replace(of, medium=MEDIUM), "none", size=size, exposure=0.0, device=device,
                        frame_settings=small_settings(shadow_resolution=1024))  # fmt: skip
    fine = renderer.render(EYE).radiance.astype(np.float64)
    found = fine.reshape(BLOCKS[1], 16, BLOCKS[0], 16, 3).mean(axis=(1, 3))
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    # Of 288 numbers one lies beyond 5 standard errors, which 16 batches know to a fifth, less than once in a thousand
    # runs; these always draw the same.
    assert np.all(np.abs(found - wanted) < 0.02 * wanted.max() + 5.0 * error)
