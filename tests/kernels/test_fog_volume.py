"""Indirect light and media: fog that reads the light volume of `uniform-lpv` against the float64 march through the same
cells, and VPLs whose light came through the medium."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from gpu_tools import small_settings
from test_rsm import vpls_of

import octolux
from octolux.renderer import Renderer
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.medium import Medium
from octolux.simulator import fog
from octolux.simulator import sh as harmonics
from octolux.simulator.camera import pixel_rays
from octolux.simulator.direct import incident
from octolux.simulator.lpv import lookup

SIZE = (96, 54)
PLACES = (slice(6, -6, 6), slice(6, -6, 6))


def fog_of(device, technique: str, scene, **settings):
    renderer = Renderer(scene, technique, settings=settings, size=SIZE, exposure=0.0, device=device,
                        frame_settings=small_settings(shadow_resolution=256, fog_resolution=1))  # fmt: skip
    return renderer, renderer.render()


def test_indirect_light_in_the_air(device):
    """What `uniform-lpv` adds to the fog of direct light is what its cells hold; steps are as long as they."""
    scene = replace(octolux.load("cornell-box"), medium=Medium(scattering=(0.05, 0.1, 0.2), absorption=(0.05,) * 3))
    renderer, picture = fog_of(device, "uniform-lpv", scene, n=16)
    _, direct = fog_of(device, "none", scene)
    grid, cells = renderer.technique.grid, renderer.technique.debug_views()["accumulated"]

    def fluence(points: np.ndarray) -> np.ndarray:
        return lookup.fluence(lookup.sample_trilinear(cells, grid, points), grid.cell_size)

    camera = scene.cameras[0]
    origins, directions = pixel_rays(camera, *SIZE)
    distance = picture.layers["depth"] / (directions @ camera.forward)
    expected = np.array([
        fog.single_scattering(scene.medium, scene.bounds(), o, d, float(r), fluence)[0]
        for o, d, r in zip(origins[PLACES].reshape(-1, 3), directions[PLACES].reshape(-1, 3), distance[PLACES].ravel(),
                           strict=True)
    ])  # fmt: skip
    added = (picture.layers["fog"].astype(np.float64) - direct.layers["fog"])[PLACES].reshape(-1, 3)
    assert abs(added.mean() / expected.mean() - 1.0) < 0.02
    assert np.abs(added - expected).mean() < 0.02 * expected.mean()


def test_the_thesis_reading_has_no_unit_for_fog(device):
    scene = replace(octolux.load("cornell-box"), medium=Medium(scattering=(0.1,) * 3))
    _, thesis = fog_of(device, "uniform-lpv", scene, n=16, reading="thesis")
    _, direct = fog_of(device, "none", scene)
    np.testing.assert_array_equal(thesis.layers["fog"], direct.layers["fog"])


@pytest.mark.parametrize("seed", [1, 2])
def test_fluence_of_a_beam_and_of_a_furnace(seed):
    """A cosine lobe of flux 3 is read as a beam, whatever way it goes; an even cell as a furnace."""
    direction = np.random.default_rng(seed).normal(size=3)
    beam = 3.0 / pi * harmonics.cosine_lobe(direction / np.linalg.norm(direction))
    np.testing.assert_allclose(lookup.fluence(np.tile(beam, (3, 1)), 0.5), 3.0 / 0.25)
    even = np.array([3.0 * harmonics.Y0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(lookup.fluence(np.tile(even, (3, 1)), 0.5), 2.0 / 3.0 * 3.0 / 0.25)


@pytest.mark.parametrize("light", [
    DirectionalLight(direction=(0.3, -1.0, -0.2), illuminance=(3.0, 2.0, 1.0)),
    PointLight(position=(0.2, 1.5, 0.1), intensity=(3.0, 2.0, 1.0)),
    SpotLight(position=(0.2, 1.5, 0.1), direction=(0.0, -1.0, -0.5), intensity=(3.0, 2.0, 1.0)),
], ids=["sun", "lamp", "spot"])  # fmt: skip
def test_vpls_reflect_what_the_medium_leaves(device, light):
    """Their flux is that in clear air times e^(-x * way from the light)."""
    medium = Medium(scattering=(0.05, 0.1, 0.2), absorption=(0.05,) * 3)
    scene = replace(octolux.load("cornell-box"), lights=[light])
    clear, dimmed = (vpls_of(device, replace(scene, medium=m)) for m in (None, medium))
    lit = clear["flux"].max(axis=-1) > 0
    position = clear["position"][lit].astype(np.float64)
    kept = fog.light_fluence(light, medium, scene.bounds(), position) / incident(light, position)[1]
    assert lit.sum() > 500 and kept.min() < 0.95
    np.testing.assert_allclose(dimmed["flux"][lit] / clear["flux"][lit], kept, rtol=1e-5)
