"""Fog on the device against closed forms and the float64 march of simulator/fog.py."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame.volume_light import VolumeLight
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import fog
from octolux.simulator.camera import pixel_rays
from octolux.simulator.direct import incident
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

LOW, HIGH = (-4.0, -3.0, -8.0), (4.0, 3.0, 0.0)
BOX = (np.array(LOW), np.array(HIGH))
HAZE = Medium(scattering=(0.05, 0.1, 0.15), absorption=(0.05, 0.0, 0.03), low=LOW, high=HIGH)
SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(9.0, 8.0, 7.0))
LAMP = PointLight(position=(1.0, 0.5, -3.0), intensity=(3.0, 2.0, 1.0))
SPOT = SpotLight(position=(0.0, 2.5, -1.0), direction=(0.0, -1.0, -0.6), intensity=(9.0, 8.0, 7.0), inner_angle=0.3,
                 outer_angle=0.8)  # fmt: skip
SIZE = (48, 32)
EYE = front_camera(2.0)
FLOAT = 1e-5  # rounding of some hundred float32 operations


def wall(z: float = -6.0, half: float = 20.0) -> Scene:
    """A black wall across the view, within the medium."""
    corners = [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]
    return scene_of([quad(corners)], [Material(base_color=(0, 0, 0), specular=0.0)], cameras=[EYE])


def render(device, scene: Scene, medium: Medium | None = HAZE, lights=(), volume=None, size=SIZE, **settings):
    """The picture's radiance, fog and transmittance, float64 (height, width, 3)."""
    scene = replace(scene, medium=medium, lights=list(lights))
    settings = {"shadow_resolution": 256, **settings}
    renderer = Renderer(scene, "none", size=size, exposure=0.0, default_light=False, device=device,
                        frame_settings=small_settings(**settings))  # fmt: skip
    if volume:
        renderer.technique = WithVolume(device, volume)
    return renderer.render()


class WithVolume(NoTechnique):
    """No indirect light on surfaces, but a light volume."""

    def __init__(self, device, volume: VolumeLight):
        super().__init__(device, Settings())
        self.volume = volume

    def update(self, frame) -> None:
        frame.volume_light = self.volume


def even_volume(fluence: float, cell: float = 0.5) -> VolumeLight:
    file = str(Path(__file__).with_name("fog_volume.wgsl"))
    return VolumeLight(file, values={"even_fluence": fluence, "even_cell": cell})


def rays(picture, camera: Camera = EYE):
    """Origins, unit directions and lengths of the lines of sight to what the picture sees; infinite where nothing."""
    height, width = picture.radiance.shape[:2]
    origins, directions = pixel_rays(camera, width, height)
    depth = picture.layers["depth"].astype(np.float64)
    along = depth / (directions @ camera.forward)
    return origins, directions, np.where(depth > 0, along, np.inf)


# Where the marched light is compared: not at the picture's rim, where the filter lacks a side.
PLACES = (slice(11, -11, 13), slice(9, -9, 13))


def expected(picture, medium: Medium, fluence, camera: Camera = EYE, steps: int = 1024):
    """Of the pixels at PLACES by the float64 march: radiance and transmittance (rows, columns, 3)."""
    lines = [x[PLACES] for x in rays(picture, camera)]
    shape = (*lines[2].shape, 3)
    found = [
        fog.single_scattering(medium, BOX, o, d, float(r), fluence, steps)
        for o, d, r in zip(lines[0].reshape(-1, 3), lines[1].reshape(-1, 3), lines[2].ravel(), strict=True)
    ]
    return np.array([f for f, _ in found]).reshape(shape), np.array([t for _, t in found]).reshape(shape)


def relative(found, wanted) -> float:
    return float((np.abs(found - wanted) / np.maximum(wanted.max(axis=-1, keepdims=True), 1e-30)).max())


@pytest.mark.parametrize("resolution", [1, 2, 4])
@pytest.mark.parametrize("cell", [0.05, 0.5, 20.0])
def test_even_light_is_exact_whatever_the_steps(device, resolution, cell):
    """L = albedo / (4 pi) * F * (1 - T), T = e^(-x l), of each pixel's own path l."""
    picture = render(device, wall(), volume=even_volume(5.0, cell), fog_resolution=resolution)
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.maximum(np.minimum(last, distance) - first, 0)[..., None]
    passed = np.exp(-HAZE.extinction * length)
    albedo = np.array(HAZE.scattering) / HAZE.extinction
    assert length.min() > 3.0
    assert relative(picture.layers["transmittance"], passed) < FLOAT
    assert relative(picture.layers["fog"], albedo / (4 * pi) * 5.0 * (1 - passed)) < FLOAT
    np.testing.assert_array_equal(picture.radiance, picture.layers["fog"])  # before a black wall


def test_fog_step_is_in_cells(device):
    """More cells a step, fewer steps; the light is the same."""
    coarse, fine = (render(device, wall(), volume=even_volume(5.0), fog_step=s).layers["fog"] for s in (3.0, 0.5))
    assert relative(coarse, fine) < FLOAT


@pytest.mark.parametrize("lights", [[SUN], [LAMP, SPOT]], ids=["sun", "lamps"])
def test_light_of_lamps_does_not_depend_on_the_steps(device, lights):
    """Steps of 0.1 and of 0.4 m: as above, but the fluence changes along the path."""
    volumes = (even_volume(0.0, cell) for cell in (0.1, 0.4))
    fine, coarse = (render(device, wall(), HAZE, lights, volume, size=(192, 128)) for volume in volumes)
    found, wanted = coarse.layers["fog"].astype(np.float64), fine.layers["fog"].astype(np.float64)
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    assert np.abs(found - wanted).mean() < 0.02 * wanted.mean()


def test_a_furnace_stays_as_it_is(device):
    """Nothing absorbs, radiance is 2 everywhere: the sky behind, and 8 pi of fluence. Seen is 2."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(0.05, 0.3, 2.0), low=LOW, high=HIGH)
    picture = render(device, scene, medium, volume=even_volume(8 * pi), sky_lights=0)
    sky = ~picture.mask
    assert sky.any() and picture.mask.any()
    assert np.abs(picture.radiance[sky] / 2.0 - 1.0).max() < FLOAT
    assert np.all(picture.radiance[picture.mask] <= 2.0)


def test_the_sky_lights_a_thin_medium_as_a_furnace(device):
    """All lights of the sky are asked: in air so thin that none is lost on the way, fog has the sky's own radiance."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(1e-5,) * 3, low=LOW, high=HIGH)
    picture = render(device, scene, medium, sky_lights=40)
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.minimum(last, distance) - first
    # The square hides some lights behind it from some points.
    away = np.abs(origins + directions * np.where(np.isfinite(distance), distance, 0)[..., None])[..., 0] > 3
    source = picture.layers["fog"][..., 0] / (1e-5 * length)
    clear = ~picture.mask & ~away
    assert source.max() <= 2.0 * (1 + 1e-3), "more than the sky has"
    assert np.median(source[clear]) > 2.0 * (1 - 0.03)


@pytest.mark.parametrize("scattering", [0.1, 1.0, 30.0])
def test_no_light_is_made(device, scattering):
    """Of an even sky through a medium that only scatters: never more than the sky, and less the denser it is, as what
    is scattered twice is lost."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    picture = render(device, scene, Medium(scattering=(scattering,) * 3, low=LOW, high=HIGH), sky_lights=40)
    assert picture.radiance.max() <= 2.0 * (1 + FLOAT)
    assert np.all(picture.layers["fog"] + 2.0 * picture.layers["transmittance"] <= 2.0 * (1 + FLOAT))


@pytest.mark.parametrize("coefficient", [1e-40, 1e-20, 1e10, 1e30])
@pytest.mark.parametrize("far", [4.0, 1e9])
def test_extreme_media_stay_finite(device, coefficient, far):
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(coefficient,) * 3, absorption=(coefficient, 0.0, 0.0), low=(-far,) * 3, high=(far,) * 3)
    picture = render(device, scene, medium, [SUN, LAMP, SPOT])
    assert np.isfinite(picture.radiance).all() and picture.radiance.min() >= 0.0
    passed = picture.layers["transmittance"]
    assert passed.min() >= 0.0 and passed.max() <= 1.0


@pytest.mark.parametrize("resolution", [1, 2])
def test_a_sun_that_the_medium_dims(device, resolution):
    """L = s E / (4 pi) e^(-x (top - y)) (1 - e^(-r l)) / r, with r = x (1 - dy) and y where the path begins."""
    picture = render(device, wall(), lights=[SUN], fog_resolution=resolution, size=(192, 128))
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.maximum(np.minimum(last, distance) - first, 0)[..., None]
    start = origins + first[..., None] * directions
    x, e = HAZE.extinction, np.array(SUN.illuminance)
    rate = x * (1 - directions[..., 1:2])
    top = np.exp(-x * (HIGH[1] - start[..., 1:2]))
    wanted = np.array(HAZE.scattering) / (4 * pi) * e * top * (1 - np.exp(-rate * length)) / rate
    assert relative(picture.layers["fog"], wanted) < 0.02


@pytest.mark.parametrize("resolution", [1, 2])
@pytest.mark.parametrize("lights", [[SUN], [LAMP], [SPOT], [SUN, LAMP, SPOT]], ids=["sun", "lamp", "spot", "all"])
def test_lights_against_float64(device, lights, resolution):
    picture = render(device, wall(), lights=lights, fog_resolution=resolution, size=(384, 256))
    wanted, passed = expected(picture, HAZE, fog.of_lights(lights, HAZE, BOX))
    assert relative(picture.layers["transmittance"][PLACES], passed) < FLOAT
    found = picture.layers["fog"].astype(np.float64)[PLACES]
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    # Near a lamp light is as 1 / angle, whose second derivative is 2 / angle^2 of it; the filter, which spreads texels
    # with a variance of 1.5 along either axis, errs there by 1.5 (texel / angle)^2: by 2 % at 9 texels. A cone's rim,
    # which has no second derivative, is left to the means.
    if SPOT not in lights:
        texel = resolution * 2 * np.tan(0.5 * EYE.vertical_fov) / 256
        to_lamp = np.array(LAMP.position) - EYE.position
        cosine = rays(picture)[1][PLACES] @ (to_lamp / np.linalg.norm(to_lamp))
        far = np.arccos(np.clip(cosine, -1, 1)) > 9 * texel
        assert far.sum() > 0.9 * far.size
        assert relative(found[far], wanted[far]) < 0.02


def shaded() -> Scene:
    """The wall, and a black plate above the medium that keeps the sun from everything at x < 0."""
    roof = quad([(-4.5, 3.5, -9), (0, 3.5, -9), (0, 3.5, 1), (-4.5, 3.5, 1)])
    scene = wall()
    return replace(scene, meshes=[*scene.meshes, roof], instances=[*scene.instances, Instance(1)])


@pytest.mark.parametrize("resolution", [1, 2])
def test_shafts_of_light(device, resolution):
    """Half of the medium is in shadow, and lines of sight cross the edge."""
    eye = Camera.look_at((1.5, 0.0, 2.0), (1.5, 0.0, 0.0))
    scene, sizes = replace(shaded(), cameras=[eye]), {"size": (384, 256), "shadow_resolution": 2048}
    picture = render(device, scene, lights=[SUN], fog_resolution=resolution, **sizes)
    lit = fog.of_lights([SUN], HAZE, BOX)
    wanted, _ = expected(picture, HAZE, lambda p: lit(p) * (p[..., :1] > 0), eye, steps=4096)
    whole, _ = expected(picture, HAZE, lit, eye)
    found = picture.layers["fog"][PLACES]
    assert np.abs(found - wanted).max() < 0.02 * whole.max()


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


# Hardware may round the weights between texels to 1/256: along each of three axes by 1/512 of at most 1.8.
FILTERING = 3 / 512 * 1.8
LIGHT_STEPS = 8  # through a density (frame/medium.py)


@pytest.mark.parametrize("resolution", [1, 2])
def test_smoke_against_float64(device, resolution):
    medium = smoke()
    picture = render(device, wall(), medium, [SUN], fog_resolution=resolution, size=(384, 256), fog_step=0.5)
    wanted, passed = expected(picture, medium, fog.of_lights([SUN], medium, BOX, LIGHT_STEPS), steps=512)
    found = picture.layers["fog"].astype(np.float64)[PLACES]
    assert relative(picture.layers["transmittance"][PLACES], passed) < 0.02
    assert relative(found, wanted) < 0.02


FLOOR = [(-3.9, -2.9, 0.0), (3.9, -2.9, 0.0), (3.9, -2.9, -7.9), (-3.9, -2.9, -7.9)]


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
