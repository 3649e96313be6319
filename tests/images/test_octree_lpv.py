"""octree-lpv as pictures: the same bits, every preset, scenes with little in them, lights that move, samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame.anti_aliasing import sample_view
from octolux.gpu.device import Device
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.meshes import Mesh
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.lpv.octree.settings import OctreeLpvSettings
from octolux.techniques.settings import SettingsError

SIZE = (48, 36)
WAYS = ["default", *OctreeLpvSettings.PRESETS]
LAMP = PointLight(position=(0.2, 1.2, 0.3), intensity=(5.0, 6.0, 7.0))


def renderer(device, scene, preset="default", size=SIZE, anti_aliasing="off", **settings) -> Renderer:
    return Renderer(
        scene, "octree-lpv", preset=preset, settings={"n": 16, **settings}, size=size, device=device,
        anti_aliasing=anti_aliasing, default_light=False, exposure=0.0,
        frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


def indirect(picture) -> np.ndarray:
    return picture.layers["indirect"]


@pytest.mark.parametrize("preset", WAYS)
def test_one_triangle(device, preset):
    """Flat, and lit: it is next to no other surface, so that it receives nothing but what a volume of its size smears:
    for the default, which reads no light behind a lobe, exactly nothing."""
    whole = quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    triangle = Mesh(**{name: getattr(whole, name)[:3] for name in ("positions", "normals", "uvs", "tangents")},
                    indices=np.array([[0, 1, 2]], np.uint32))  # fmt: skip
    lamp = PointLight(position=(0.0, 0.0, 1.0), intensity=(3.0, 3.0, 3.0))
    picture = renderer(device, scene_of([triangle], lights=[lamp]), preset).render(front_camera())
    assert picture.layers["direct"].max() > 0 and np.isfinite(picture.radiance).all()
    if preset == "default":
        assert indirect(picture).max() <= 1e-5 * picture.layers["direct"].max()


OUTSIDE = {
    "point": PointLight(position=(0.0, 40.0, 0.0), intensity=(6400.0, 6400.0, 6400.0)),
    "spot": SpotLight(position=(0.0, 40.0, 0.0), direction=(0.0, -1.0, 0.0), intensity=(6400.0, 6400.0, 6400.0),
                      outer_angle=0.3),
    "directional": DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(4.0, 4.0, 4.0)),
}  # fmt: skip


def court() -> list[Mesh]:
    """A floor of 4 m^2 and a wall at its back, open to the sky."""
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    return [floor, quad([(-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)])]


@pytest.mark.parametrize(("preset", "kind"), [*((p, "point") for p in WAYS), ("default", "spot"),
                                              ("default", "directional")])  # fmt: skip
def test_lights_outside_the_volume(device, preset, kind):
    """They light the scene as if it had no bounds: what they send is injected, and the wall gets light from the floor.
    A lamp at 40 m with 6400 cd is as a sun of 4 lx."""
    scene = scene_of(court(), [Material(base_color=(0.5, 0.5, 0.5), specular=0.0)], lights=[OUTSIDE[kind]])
    picture = renderer(device, scene, preset).render(front_camera(4.0))
    wall = picture.layers["normal"][..., 2] > 0.9
    assert wall.any() and indirect(picture)[wall].mean() > 0
    assert np.isfinite(picture.radiance).all()


def test_flux_of_a_light_outside_the_volume(device):
    """All that the lights send onto a floor is in the volume: albedo / 2 of 4 lx on 4 m^2, to the RSM's texels at the
    floor's rim: 32 texels over some 2.8 m, so at most half of one in 22 at each of four sides."""
    scene = scene_of(court()[:1], [Material(base_color=(0.5, 0.5, 0.5), specular=0.0)],
                     lights=[OUTSIDE["directional"]])  # fmt: skip
    made = renderer(device, scene)
    made.render(front_camera(4.0))
    injected = total_flux(made.technique.debug_views()["injected"][0])
    np.testing.assert_allclose(injected, 8.0, rtol=4 * 0.5 / 22)


@pytest.mark.parametrize("preset", WAYS)
def test_lights_that_move_come_and_go(device, preset):
    """Frames are those of a fresh renderer, also after more lights: nothing is left in any volume."""
    scene = load_scene("cornell-box")
    made, pictures = renderer(device, scene, preset), []
    elsewhere = replace(LAMP, position=(-0.5, 0.6, 0.5))
    for lights in ([LAMP], [elsewhere], [LAMP, OUTSIDE["directional"], LAMP], [], [LAMP]):
        made.scene = replace(scene, lights=lights)
        pictures.append(made.render())
    fresh = renderer(device, replace(scene, lights=[elsewhere]), preset).render()
    first, moved, _, _, last = map(indirect, pictures)
    assert np.array_equal(pictures[1].radiance, fresh.radiance) and np.array_equal(first, last)
    lit = first > 0.1 * first.mean()
    assert np.median(np.abs(moved - first)[lit] / first[lit]) > 0.02


def samples_alone(device, scene, monkeypatch, **settings) -> tuple[np.ndarray, np.ndarray]:
    """A picture of four samples a pixel, and the mean of four pictures of one of these samples each: indirect light."""
    four = renderer(device, scene, anti_aliasing=4, **settings).render().radiance
    alone = []
    for k in range(4):
        with monkeypatch.context() as patched:
            patched.setattr("octolux.renderer.sample_view", lambda view, _k, _n, k=k: sample_view(view, k, 4))
            alone.append(renderer(device, scene, **settings).render().radiance)
    return four, np.mean(alone, axis=0)


def test_samples_share_a_volume_that_is_all_filled(device, monkeypatch):
    """With all cells filled and no surfels of the camera, whose first sample alone counts, samples are as if alone, to
    the rounding of their sum."""
    scene = replace(load_scene("cornell-box"), lights=[LAMP])
    four, mean = samples_alone(device, scene, monkeypatch, cells="all", surfels="lamps")
    np.testing.assert_allclose(four, mean, rtol=8 * 2.0**-24, atol=1e-6)


def test_samples_fill_newly_seen_cells(device, monkeypatch):
    """What the first sample has not seen is not dark in the others. Each finds the cells of those before filled as
    well, and filters among more of them, which evens out the light from cell to cell and changes no mean much."""
    scene = replace(load_scene("cornell-box"), lights=[LAMP])
    four, mean = samples_alone(device, scene, monkeypatch, surfels="lamps")
    assert four.mean() == pytest.approx(mean.mean(), rel=0.02)
    assert np.all(four >= 0.5 * mean)


@pytest.mark.parametrize(("changes", "says"), [
    ({"n": 48}, "'n' is one of 16, 32, 64, 128, not 48"), ({"n": 8}, "'n'"), ({"iterations": -1}, "'iterations'"),
    ({"iterations": 100_000}, "'iterations'"), ({"coarsest": 4}, "'coarsest'"), ({"threshold": -0.1}, "'threshold'"),
    ({"occlusion": 2}, "'occlusion'"), ({"propagation": "gathr"}, "gather, steps"), ({"itrations": 1}, "'iterations'"),
])  # fmt: skip
def test_settings_that_are_refused(changes, says):
    with pytest.raises(SettingsError, match=says):
        OctreeLpvSettings.make(**changes)


def test_unknown_presets_are_refused():
    with pytest.raises(SettingsError, match="'thesis'"):
        OctreeLpvSettings.make("thsis")


def test_without_steps_and_with_everything_gathered(device):
    """k = 0 is a picture, and cells "all" is the same light where surfaces are, filtered with cells in the air."""
    scene = replace(load_scene("cornell-box"), lights=[LAMP])
    still = renderer(device, scene, "steps", iterations=0).render()
    assert indirect(still).any() and np.isfinite(still.radiance).all()
    seen, whole = (indirect(renderer(device, scene, cells=cells).render()) for cells in ("seen", "all"))
    assert not np.array_equal(seen, whole)
    assert whole.mean() == pytest.approx(seen.mean(), rel=0.25)


def test_occlusion_takes_light_away(device):
    scene = replace(load_scene("cornell-box"), lights=[LAMP])
    free, blocked = (indirect(renderer(device, scene, occlusion=o).render()) for o in (False, True))
    assert blocked.mean() < free.mean() and (blocked <= free * (1 + 2.0**-9) + 1e-6).all()


def test_a_closed_box_stays_within_its_walls(device):
    """A lamp outside a closed box lights nothing within it."""
    lamp = PointLight(position=(0.0, 5.0, 0.0), intensity=(900.0, 900.0, 900.0))
    walls = [box((-1, -1, -1), (1, 1, 1), inward=True), box((-1.5, -1.5, -1.5), (1.5, 1.5, 1.5))]
    scene = scene_of(walls, [Material(specular=0.0)], lights=[lamp])
    picture = renderer(device, scene).render(front_camera(0.5))
    assert not picture.layers["direct"].any()
    assert indirect(picture).max() < 1e-3 * 900.0 / 3.5**2 / np.pi


@pytest.mark.parametrize("preset", WAYS)
def test_memory_does_not_grow(preset):
    """Thirty frames with lights that move, three, two, one and again: shadow maps are as many as the lights, and after
    the first three frames nothing else is made."""
    scene, device = load_scene("cornell-box"), Device()  # of others, things may be collected meanwhile
    made, held = renderer(device, scene, preset, size=(16, 12)), []
    for k in range(30):
        lamps = [replace(LAMP, position=(0.5 * np.cos(k + i), 1.0, 0.5 * np.sin(k - i))) for i in range(3 - k % 3)]
        made.scene = replace(scene, lights=lamps)
        made.render()
        held.append(device.memory.total)
    assert held[3:] == held[3:6] * 9


@pytest.mark.parametrize(("changes", "remedy"), [({"combine": "average"}, "combine=sum"),
                                                 ({"injection": "thesis"}, "injection=flux")])  # fmt: skip
def test_gathering_takes_no_settings_that_lose_flux(changes, remedy):
    with pytest.raises(SettingsError, match=remedy):
        OctreeLpvSettings.make(**changes)
