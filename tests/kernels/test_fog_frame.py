"""Fog in a frame: silhouettes, densities, what reaches surfaces, layers, and scenes without any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fog_tools import (
    BOX,
    EYE,
    FLOAT,
    HAZE,
    LAMP,
    PLACES,
    SIZE,
    SPOT,
    SUN,
    even_volume,
    expected,
    relative,
    render,
    shaded,
    wall,
)  # fmt: skip
from gpu_tools import front_camera, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.environment import Environment
from octolux.scene.errors import OctoluxError
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.meshes import Instance
from octolux.simulator import fog
from octolux.simulator.direct import incident

# Hardware may round the weights between texels to 1/256: along each of three axes by 1/512 of at most 1.8.
FILTERING = 3 / 512 * 1.8
LIGHT_STEPS = 8  # through a density (frame/medium.py)
FLOOR = [(-3.9, -2.9, 0.0), (3.9, -2.9, 0.0), (3.9, -2.9, -7.9), (-3.9, -2.9, -7.9)]


@pytest.mark.parametrize("coefficient", [1e-40, 1e-20, 1e10, 1e30])
@pytest.mark.parametrize("far", [4.0, 1e9])
def test_extreme_media_stay_finite(device, coefficient, far):
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(coefficient,) * 3, absorption=(coefficient, 0.0, 0.0), low=(-far,) * 3, high=(far,) * 3)
    picture = render(device, scene, medium, [SUN, LAMP, SPOT])
    assert np.isfinite(picture.radiance).all() and picture.radiance.min() >= 0.0
    passed = picture.layers["transmittance"]
    assert passed.min() >= 0.0 and passed.max() <= 1.0


def test_half_resolution_does_not_bleed_across_silhouettes(device):
    """A square near the eye before a far wall: its fog is thin, and so it stays next to its rim."""
    near = quad([(-0.5, -0.5, -1), (0.5, -0.5, -1), (0.5, 0.5, -1), (-0.5, 0.5, -1)])
    scene = wall(-7.5)
    scene = replace(scene, meshes=[*scene.meshes, near], instances=[*scene.instances, Instance(1)])
    whole, half, quarter = (
        render(device, scene, lights=[SUN], size=(192, 128), fog_resolution=r) for r in (1, 2, 4)
    )  # fmt: skip
    front = whole.layers["depth"] < 5.0
    assert 0 < front.sum() < front.size
    exact, contrast = whole.layers["fog"], whole.layers["fog"][~front].mean() / whole.layers["fog"][front].mean()
    assert contrast > 4.0
    for picture in (half, quarter):
        np.testing.assert_array_equal(picture.layers["transmittance"], whole.layers["transmittance"])
        assert relative(picture.layers["fog"], exact) < 0.03
        # The square's neighbours in depth are ten times as deep: what they count is below alike(1, 8) = 1 / 5863 each.
        rim = front & (np.roll(~front, 1, 0) | np.roll(~front, -1, 0) | np.roll(~front, 1, 1) | np.roll(~front, -1, 1))
        assert relative(picture.layers["fog"][rim], exact[rim]) < 0.03


def smoke(seed: int = 5) -> Medium:
    """Cells of 1 m with densities that differ up to tenfold."""
    rng = np.random.default_rng(seed)
    density = rng.uniform(0.2, 2.0, (8, 6, 8)).astype(np.float32)
    return replace(HAZE, density=density)


def test_an_even_density_is_as_none(device):
    """Of 4, which is the coefficients times 4: in the air, and between the sun and what it meets."""
    even = replace(HAZE, density=np.full((2, 3, 4), 4.0, np.float32))
    times = {name: tuple(4.0 * v for v in getattr(HAZE, name)) for name in ("scattering", "absorption")}
    one, other = (render(device, wall(), m, [SUN], fog_step=0.05) for m in (even, replace(HAZE, **times)))
    assert relative(one.layers["transmittance"], other.layers["transmittance"]) < 10 * FLOAT
    assert relative(one.layers["fog"], other.layers["fog"]) < 0.01


@pytest.mark.parametrize("resolution", [1, 2])
def test_smoke_against_float64(device, resolution):
    medium = smoke()
    picture = render(device, wall(), medium, [SUN], fog_resolution=resolution, size=(384, 256), fog_step=0.5)
    wanted, passed = expected(picture, medium, fog.of_lights([SUN], medium, BOX, LIGHT_STEPS), steps=512)
    found = picture.layers["fog"].astype(np.float64)[PLACES]
    assert relative(picture.layers["transmittance"][PLACES], passed) < 0.02
    assert relative(found, wanted) < 0.02


@pytest.mark.parametrize("light", [SUN, LAMP, SPOT], ids=["sun", "lamp", "spot"])
@pytest.mark.parametrize("medium", [HAZE, smoke()], ids=["haze", "smoke"])
def test_surfaces_get_what_the_medium_leaves(device, light, medium):
    """Direct light of a white floor: that in clear air times e^(-depth between light and surface)."""
    scene = scene_of([quad(FLOOR)], [Material(base_color=(1, 1, 1), specular=0.0)], cameras=[EYE])
    clear, dimmed = (render(device, scene, m, [light]) for m in (None, medium))
    where = clear.layers["direct"].max(axis=-1) > 1e-3 * clear.layers["direct"].max()
    position = clear.layers["position"][where].astype(np.float64)
    kept = fog.light_fluence(light, medium, BOX, position, LIGHT_STEPS) / incident(light, position)[1]
    found = dimmed.layers["direct"][where] / clear.layers["direct"][where]
    assert where.sum() > 100
    rounding = 0.0 if medium is HAZE else FILTERING * medium.extinction.max() * 10.0  # m, of light in the box
    assert np.abs(found / kept - 1).max() < rounding + 10 * FLOAT


def test_a_picture_is_what_passes_and_what_is_scattered(device):
    scene = scene_of([quad(FLOOR)], [Material(base_color=(0.5, 0.6, 0.7), emissive=(1, 2, 3))], cameras=[EYE],
                     environment=Environment((3.0, 2.0, 1.0)))  # fmt: skip
    picture = render(device, scene, lights=[SUN, LAMP])
    layer = picture.layers
    behind = np.where(picture.mask[..., None], layer["direct"] + layer["emissive"], [3.0, 2.0, 1.0])
    assert relative(picture.radiance, behind * layer["transmittance"] + layer["fog"]) < FLOAT
    covered = np.where(picture.mask, 1.0, 1.0 - layer["transmittance"].mean(axis=-1))
    assert np.abs(picture.alpha - covered).max() < FLOAT


def test_an_orthographic_eye(device):
    eye = front_camera(2.0, orthographic_height=4.0)
    picture = render(device, replace(wall(), cameras=[eye]), volume=even_volume(5.0))
    wanted = np.exp(-HAZE.extinction * 6.0)
    assert relative(picture.layers["transmittance"], np.broadcast_to(wanted, picture.radiance.shape)) < FLOAT


def test_several_samples_and_odd_sizes(device):
    """Each sample has its own fog; blocks of pixels may stand out of the picture."""
    scene = replace(wall(), medium=HAZE, lights=[SUN])
    settings = small_settings(shadow_resolution=256, fog_resolution=4)
    pictures = [
        Renderer(scene, "none", size=(37, 23), exposure=0.0, device=device, anti_aliasing=samples,
                 frame_settings=settings).render().radiance
        for samples in ("off", 4)
    ]  # fmt: skip
    assert relative(pictures[1], pictures[0].astype(np.float64)) < 0.05


def test_fog_has_the_same_bits_in_every_run(device):
    pictures = [render(device, shaded(), lights=[SUN, LAMP], volume=even_volume(2.0)).radiance for _ in range(2)]
    np.testing.assert_array_equal(*pictures)


def test_clear_air_costs_nothing(device):
    scene = replace(wall(), lights=[SUN])
    held = dict(device.memory.by_label())
    renderer = Renderer(scene, "none", size=SIZE, exposure=0.0, device=device, profile=True)
    picture = renderer.render()
    assert "fog" not in [stage["name"] for stage in renderer.profiler.stages()]
    grown = {label for label, size in device.memory.by_label().items() if size > held.get(label, 0)}
    assert not [label for label in grown if "fog" in label or "medium" in label]
    assert not picture.layers["fog"].any() and np.all(picture.layers["transmittance"] == 1.0)
    renderer.scene.medium = HAZE  # and it may come and go
    assert renderer.render().layers["fog"].any()
    renderer.scene.medium = None
    np.testing.assert_array_equal(renderer.render().radiance, picture.radiance)


@pytest.mark.parametrize("wrong", [{"fog_resolution": 3}, {"fog_step": 0.0}, {"fog_step": float("nan")}])
def test_wrong_settings_are_refused(device, wrong):
    with pytest.raises(OctoluxError, match=next(iter(wrong))):
        render(device, wall(), **wrong)


def test_what_stands_in_the_way_of_fog_is_said(device):
    medium = Medium(scattering=(1.0,) * 3)
    tracer = Renderer(replace(wall(), medium=medium), "path-tracer", size=(4, 4), device=device)
    assert any("path-tracer knows no media" in note for note in tracer.warnings)
    flat = Renderer(replace(wall(), medium=medium), "none", size=(4, 4), device=device)
    assert any("give it 'low' and 'high'" in note for note in flat.warnings)
    assert Renderer(replace(wall(), medium=HAZE, lights=[SUN]), "none", size=(4, 4), device=device).warnings == []
