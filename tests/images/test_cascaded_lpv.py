"""cascaded-lpv as pictures: the same bits, every preset, cascades one by one, what moves, what is small, settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.gpu.device import Device
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.settings import SettingsError

SIZE = (48, 36)
WAYS = ["default", *CascadedLpvSettings.PRESETS]
STEPS = ["steps", "paper"]
LAMP = PointLight(position=(0.2, 1.2, 0.3), intensity=(5.0, 6.0, 7.0))


def renderer(device, scene, preset="default", size=SIZE, technique="cascaded-lpv", **settings) -> Renderer:
    return Renderer(
        scene, technique, preset=preset, settings={"n": 16, **settings}, size=size, device=device, exposure=0.0,
        anti_aliasing="off", default_light=False, frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


def indirect(picture) -> np.ndarray:
    return picture.layers["indirect"]


@pytest.mark.parametrize("cascades", [1, 2, 5])
@pytest.mark.parametrize("preset", WAYS)
def test_any_number_of_cascades(device, preset, cascades):
    picture = renderer(device, load_scene("cornell-box"), preset, cascades=cascades).render()
    assert indirect(picture).any() and np.isfinite(picture.radiance).all()


def test_one_cascade_without_occlusion_is_the_uniform_volume(device):
    """To the bit: the paper's numbers are the same in both."""
    scene, changes = load_scene("cornell-box"), {"cascades": 1, "occlusion": False, "ambient_occlusion": False}
    one = renderer(device, scene, "paper", small_objects="keep", **changes).render()
    uniform = renderer(device, scene, "paper", technique="uniform-lpv").render()
    assert indirect(one).any() and np.array_equal(one.radiance, uniform.radiance)


def court() -> list[Mesh]:
    """A floor of 4 m^2 and a wall at its back, open to the sky."""
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    return [floor, quad([(-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)])]


SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(4.0, 4.0, 4.0))
GREY = Material(base_color=(0.5, 0.5, 0.5), specular=0.0)


@pytest.mark.parametrize("preset", STEPS)
def test_every_cascade_holds_the_flux_of_what_is_in_it(device, preset):
    """The outermost all that the sun sends back from a floor: albedo / 2 of 4 lx on 4 m^2, to the RSM's texels at the
    floor's rim (test_octree_lpv.py: half of one in 22 at each side); each finer one no more than the coarser."""
    made = renderer(device, scene_of(court()[:1], [GREY], lights=[SUN]), preset)
    made.render(front_camera(0.2))
    views = made.technique.debug_views()
    flux = [total_flux(level)[0] for level in views["injected"]]
    np.testing.assert_allclose(flux[-1], 8.0, rtol=4 * 0.5 / 22)
    assert 0.0 < flux[0] < flux[1] < flux[2]
    assert [level.shape for level in views["accumulated"]] == [(16, 16, 16, 3, 4)] * 3
    assert all(0.0 < level.max() <= 1.0 for level in views["blocked"])


@pytest.mark.parametrize("still", [True, False])
@pytest.mark.parametrize("preset", STEPS)
def test_cascades_propagate_alone(device, preset, still):
    """What a cascade accumulates is no more than its own light, once for each step and once at the start, and nothing
    but that without steps. Clamped evaluation adds up to 14 % once (CLPV 3.3; papers' own); f16 2^-11 a step."""
    iterations = 0 if still else 4
    made = renderer(device, load_scene("cornell-box"), preset, iterations=iterations, occlusion=False)
    made.render()
    views = made.technique.debug_views()
    for injected, accumulated in zip(views["injected"], views["accumulated"], strict=True):
        own, found = total_flux(injected), total_flux(accumulated)
        if still:
            np.testing.assert_array_equal(accumulated, injected)
        assert np.all(found <= (iterations + 1) * 1.15 * own + 1e-6) and np.all(found >= own * (1 - 1e-5))


@pytest.mark.parametrize("preset", WAYS)
def test_lights_that_move_come_and_go(device, preset):
    """Frames are those of a fresh renderer, also after more lights: nothing is left in any volume."""
    scene = load_scene("cornell-box")
    made, pictures = renderer(device, scene, preset), []
    elsewhere = replace(LAMP, position=(-0.5, 0.6, 0.5))
    for lights in ([LAMP], [elsewhere], [LAMP, SUN, LAMP], [], [LAMP]):
        made.scene = replace(scene, lights=lights)
        pictures.append(made.render())
    fresh = renderer(device, replace(scene, lights=[elsewhere]), preset).render()
    first, moved, _, _, last = map(indirect, pictures)
    assert np.array_equal(pictures[1].radiance, fresh.radiance) and np.array_equal(first, last)
    lit = first > 0.1 * first.mean()
    assert np.median(np.abs(moved - first)[lit] / first[lit]) > 0.02


def with_cube(x: float, edge: float = 0.5) -> Scene:
    """The court and a cube on its floor, at `x`."""
    half = 0.5 * edge
    place = np.eye(4)
    place[:3, 3] = (x, half, 0.0)
    instances = [Instance(0), Instance(1), Instance(2, transform=place)]
    return scene_of([*court(), box((-half,) * 3, (half,) * 3)], [GREY], lights=[SUN], instances=instances)


@pytest.mark.parametrize("preset", WAYS)
def test_objects_that_move(device, preset):
    """The picture after a move is that of a fresh renderer. Samples of the scene's own surfaces move with them: there
    and back again it is the first picture."""
    camera, pictures = front_camera(4.0), []
    made = renderer(device, with_cube(-0.5), preset)
    for x in (-0.5, 0.5, -0.5):
        made.scene = with_cube(x)
        pictures.append(made.render(camera))
    before, after, again = pictures
    assert np.array_equal(before.radiance, again.radiance)
    assert np.abs(indirect(after) - indirect(before)).max() > 0.05 * indirect(before).max()
    seen = renderer(device, with_cube(-0.5), preset, surfels="lamps and camera")
    seen.render(camera)
    seen.scene = with_cube(0.5)
    fresh = renderer(device, with_cube(0.5), preset, surfels="lamps and camera").render(camera)
    assert np.array_equal(seen.render(camera).radiance, fresh.radiance)


@pytest.mark.parametrize("propagation", ["gather", "steps"])
def test_small_objects_fade(device, propagation):
    """Cells are 2 m / 14 = 14 cm long: of a cube of 10 cm, on which there is one of the RSM's texels of some 9 cm at
    least, a part of the light goes; of one of 1 m, and of the court, nothing. What has not moved fades with "fade"
    alone."""

    def injected(*places: float, edge: float = 0.1, small_objects: str = "keep") -> float:
        made = renderer(device, with_cube(places[0], edge), propagation=propagation, bounces=1, cascades=1,
                        small_objects=small_objects)  # fmt: skip
        for x in places:
            made.scene = with_cube(x, edge)
            made.render(front_camera(4.0))
        return float(total_flux(made.technique.debug_views()["injected"][0])[0])

    kept = injected(0.0)
    assert 0.9 * kept < injected(0.0, small_objects="fade") < kept
    assert injected(0.0, small_objects="fade moving") == kept
    assert injected(0.0, edge=1.0, small_objects="fade") == injected(0.0, edge=1.0)
    moved = injected(0.0, 0.3)
    assert moved == injected(0.3) and injected(0.0, 0.3, small_objects="fade moving") < moved


@pytest.mark.parametrize("preset", STEPS)
def test_occlusion_takes_light_away_and_bounces_bring_some(device, preset):
    """Of the flux in every cascade but the finest, which lies before the box; and occlusion of the picture."""
    scene, flux, light = replace(load_scene("cornell-box"), lights=[LAMP]), [], []
    for changes in ({"occlusion": False}, {}, {"bounces": 3}):
        made = renderer(device, scene, preset, **changes)
        light.append(indirect(made.render()).mean())
        flux.append([total_flux(level).sum() for level in made.technique.debug_views()["accumulated"][1:]])
    free, blocked, bounced = np.array(flux)
    assert np.all(blocked > 0.0) and np.all(blocked < free) and np.all(blocked < bounced)
    assert 0.0 < light[1] < light[0]


def test_reflection_has_a_colour(device):
    """Beside the red wall, at the left, there is more red over green than beside the green one; the more so when each
    colour is reflected by itself."""
    scene = replace(load_scene("cornell-box"), lights=[LAMP])

    def contrast(reflection: str) -> float:
        light = indirect(renderer(device, scene, "steps", bounces=3, reflection=reflection).render())
        left, right = (half.sum(axis=(0, 1)) for half in np.split(light, 2, axis=1))
        return left[0] / left[1] / (right[0] / right[1])

    assert contrast("spectral") > 1.02 * contrast("mono") > 1.02


@pytest.mark.parametrize("preset", STEPS)
def test_fog_shows_the_cascades_light(device, preset):
    scene = replace(load_scene("cornell-box"), medium=Medium(scattering=(0.1,) * 3))
    with_light = renderer(device, scene, preset).render().layers["fog"]
    direct = Renderer(scene, "none", size=SIZE, device=device, exposure=0.0, anti_aliasing="off",
                      frame_settings=small_settings(sky_lights=0, emitter_lights=0)).render().layers["fog"]  # fmt: skip
    assert np.isfinite(with_light).all() and with_light.mean() > 1.01 * direct.mean()


@pytest.mark.parametrize("preset", WAYS)
def test_memory_does_not_grow(preset):
    """With lights that move and whose number changes, nothing is made after the first three frames."""
    scene, device = load_scene("cornell-box"), Device()  # of others, things may be collected meanwhile
    made, held = renderer(device, scene, preset, size=(16, 12)), []
    for k in range(12):
        lamps = [replace(LAMP, position=(0.5 * np.cos(k + i), 1.0, 0.5 * np.sin(k - i))) for i in range(3 - k % 3)]
        made.scene = replace(scene, lights=lamps)
        made.render()
        held.append(device.memory.total)
    assert held[3:] == held[3:6] * 3


@pytest.mark.parametrize(("changes", "says"), [
    ({"n": 24}, "'n' is one of 16, 32, 64, not 24"), ({"cascades": 0}, "'cascades'"), ({"bounces": 0}, "'bounces'"),
    ({"iterations": -1}, "'iterations'"), ({"small_objects": "drop"}, "keep, fade moving, fade"),
    ({"surfels": "all"}, "'surfels'"),
    ({"propagation": "march"}, "gather, steps"), ({"injection": "thesis"}, "injection=flux"),
    ({"propagation": "steps", "reading": "thesis"}, "reading=dominant_lobe or paper"),
    ({"propagation": "steps", "occlusion": False}, "occlusion=true, or bounces=1"),
    ({"damping": True}, "'gather' has no steps.*damping"), ({"reflection": "mono"}, "reflection"),
    ({"evaluation": "clamped", "cell_format": "f16"}, "evaluation, cell_format"), ({"cascade": 3}, "'cascades'"),
])  # fmt: skip
def test_settings_that_are_refused(changes, says):
    with pytest.raises(SettingsError, match=says):
        CascadedLpvSettings.make(**changes)


def test_unknown_presets_are_refused():
    with pytest.raises(SettingsError, match="'paper'"):
        CascadedLpvSettings.make("papers")
