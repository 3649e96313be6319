"""Shadow maps and RSMs are drawn only when something that they show has changed; pictures are a fresh renderer's."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from gpu_tools import small_settings

from octolux.frame.visibility import VisibilityPass
from octolux.gpu.profiler import Profiler
from octolux.gpu_scene.history import MOVING_SYNCS
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, DirectionalLight, PointLight, SpotLight
from octolux.scene.load import load_scene
from octolux.scene.medium import Medium
from octolux.scene.scene import Scene
from octolux.techniques import technique_class

SMALL = {
    "none": {}, "uniform-lpv": {"n": 16, "iterations": 4}, "octree-lpv": {"n": 16}, "cascaded-lpv": {"n": 16},
    "voxel-cones": {"depth": 6},
}  # fmt: skip
LAMP = PointLight(position=(0.2, 1.2, 0.3), intensity=(5.0, 6.0, 7.0))
SPOT = SpotLight(position=(-0.4, 1.8, 0.2), direction=(0.1, -1.0, 0.1), intensity=(9.0, 8.0, 7.0))
SUN = DirectionalLight(direction=(0.2, -0.6, -1.0), illuminance=(3.0, 3.0, 2.0))
PANEL = AreaLight(corners=((-0.2, 1.9, -0.2), (0.2, 1.9, -0.2), (0.2, 1.9, 0.2), (-0.2, 1.9, 0.2)), radiance=(9.0,) * 3)
VPLS = {"RSM surfaces"}
BOTH = {"RSM rendering", *VPLS}
"""Stages of all that is drawn from lights."""


def scene() -> Scene:
    """The Cornell box with a light of each kind, a block that is half there, and fog."""
    box = load_scene("cornell-box")
    half = replace(box.materials[0], alpha=0.5, alpha_mode="blend")
    block = replace(box.meshes[-1], material=len(box.materials))
    return replace(
        box, lights=[LAMP, SPOT, SUN, PANEL], meshes=[*box.meshes[:-1], block], materials=[*box.materials, half],
        environment=Environment((0.5, 0.6, 0.8)), exposure=2.0, medium=Medium(absorption=(0.1,) * 3),
    )  # fmt: skip


def renderer(device, of: Scene, technique: str = "uniform-lpv") -> Renderer:
    made = Renderer(
        of, technique, settings=SMALL[technique], size=(32, 24), device=device, frame_settings=small_settings()
    )
    made.profiler = Profiler(device, "fenced")
    return made


def drawn(made: Renderer) -> set[str]:
    """The stages of maps in the last frame."""
    return set(made.profiler.last_frame()) & {*BOTH, "shadow maps"}


def same(a: Picture, b: Picture) -> bool:
    """In all that a frame shows by itself."""
    return all(np.array_equal(a.layers[name], b.layers[name]) for name in a.layers if name != "motion")


@pytest.mark.parametrize("technique", SMALL)
def test_a_still_frame_draws_no_maps(device, technique):
    """And has the bits of one that does."""
    made = renderer(device, scene(), technique)
    first = made.render()
    assert drawn(made) == ({"shadow maps"} if technique == "none" else BOTH)
    assert same(made.render(), first) and not drawn(made)
    made.forget()
    assert same(made.render(), first) and drawn(made)


@dataclass(frozen=True)
class Change:
    """of: what it does to a scene.  draws: the stages that it asks for."""

    of: Callable[[Scene], Scene]
    draws: set[str]


def _lights(*lights) -> Callable[[Scene], Scene]:
    return lambda s: replace(s, lights=[*lights])


def _material(**values) -> Callable[[Scene], Scene]:
    def of(s: Scene) -> Scene:
        number = s.meshes[-1].material
        return replace(s, materials=[replace(m, **values) if n == number else m for n, m in enumerate(s.materials)])

    return of


def _moved(s: Scene) -> Scene:
    transform = s.instances[-1].transform.copy()
    transform[:3, 3] += [0.1, 0.2, 0.1]
    return replace(s, instances=[*s.instances[:-1], replace(s.instances[-1], transform=transform)])


def _reshaped(s: Scene) -> Scene:
    mesh = s.meshes[-1]
    return replace(s, meshes=[*s.meshes[:-1], replace(mesh, positions=mesh.positions * np.float32(0.8))])


CHANGES = {
    "nothing": Change(lambda s: replace(s, lights=[replace(light) for light in s.lights]), set()),
    "light moved": Change(_lights(replace(LAMP, position=(0.1, 1.1, 0.2)), SPOT, SUN, PANEL), BOTH),
    "light turned": Change(_lights(LAMP, SPOT, replace(SUN, direction=(0.1, -0.5, -1.0)), PANEL), BOTH),
    "cone narrower": Change(_lights(LAMP, replace(SPOT, outer_angle=0.5), SUN, PANEL), BOTH),
    "cone softer": Change(_lights(LAMP, replace(SPOT, inner_angle=0.5), SUN, PANEL), VPLS),
    "colour": Change(_lights(LAMP, replace(SPOT, intensity=(1.0, 8.0, 1.0)), SUN, PANEL), VPLS),
    "lights swapped": Change(_lights(replace(LAMP, intensity=(1.0,) * 3), LAMP, SPOT, SUN, PANEL), BOTH),
    "fewer lights": Change(_lights(SPOT, PANEL), BOTH),
    "panel dimmed": Change(_lights(LAMP, SPOT, SUN, replace(PANEL, radiance=(4.5,) * 3)), VPLS),
    "sky": Change(lambda s: replace(s, environment=Environment((0.9, 0.1, 0.1))), BOTH),
    "darker sky": Change(lambda s: replace(s, environment=Environment((0.25, 0.3, 0.4))), VPLS),
    "black sky": Change(lambda s: replace(s, environment=Environment()), BOTH),
    "medium": Change(lambda s: replace(s, medium=Medium(absorption=(0.9, 0.1, 0.1))), VPLS),
    "clear air": Change(lambda s: replace(s, medium=None), VPLS),
    "object moved": Change(_moved, BOTH),
    "object reshaped": Change(_reshaped, BOTH),
    "object gone": Change(lambda s: replace(s, instances=s.instances[:-1]), BOTH),
    "paint": Change(_material(base_color=(0.1, 0.7, 0.1)), BOTH),
    "alpha": Change(_material(alpha=0.8), BOTH),
    "opaque": Change(_material(alpha_mode="opaque"), BOTH),
    "glow": Change(_material(emissive=(2.0, 1.0, 0.5)), BOTH),
}


@pytest.fixture(scope="module")
def kept(device) -> Renderer:
    """One that has seen all the changes before."""
    return renderer(device, scene())


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_is_drawn(kept, name):
    """There and back: both pictures are a fresh renderer's."""
    change, still = CHANGES[name], scene()
    kept.scene = still
    before = kept.render()
    kept.scene = change.of(still)
    changed = kept.render()
    assert drawn(kept) == change.draws
    assert same(changed, renderer(kept.device, kept.scene).render())
    assert same(changed, before) == (name == "nothing")
    kept.scene = still
    assert same(kept.render(), before)


def test_only_the_faces_of_a_light_that_moves_are_drawn(device, monkeypatch):
    made, plain, views = renderer(device, scene(), "none"), VisibilityPass.draw, []

    def counted(self, stage, frame, view, *rest):
        views.append(view)
        plain(self, stage, frame, view, *rest)

    monkeypatch.setattr(VisibilityPass, "draw", counted)
    made.render()
    assert len(views) > 1 + 8 and len(views) == len(set(views))
    views.clear()
    made.scene = replace(made.scene, lights=[LAMP, replace(SPOT, position=(-0.3, 1.7, 0.2)), SUN, PANEL])
    made.render()
    assert views == [0, 2]  # the camera, and the one of the spot light, which comes after the sun


@pytest.mark.parametrize("technique", ["none", "uniform-lpv"])
def test_after_a_frame_that_failed_all_is_drawn(device, technique, monkeypatch):
    """It was never submitted, so that nothing of it is there."""
    made = renderer(device, scene(), technique)
    made.profiler = Profiler(device, "off")
    made.render()
    made.scene = replace(made.scene, lights=[replace(LAMP, position=(0.1, 1.1, 0.2)), SPOT, SUN, PANEL])
    with monkeypatch.context() as broken, pytest.raises(ZeroDivisionError):
        broken.setattr(made.technique, "shade", lambda frame: 1 // 0)
        made.render()
    assert same(made.render(), renderer(device, made.scene, technique).render())


def test_another_technique_or_other_settings(device):
    """Maps without triangle numbers are not taken for RSMs, nor small ones for large ones."""
    made = renderer(device, scene(), "none")
    made.render()
    made.technique = technique_class("uniform-lpv")(device, renderer(device, scene()).technique.settings)
    assert same(made.render(), renderer(device, scene()).render()) and drawn(made) == BOTH
    made = renderer(device, scene(), "none")
    for change in ({"shadow_resolution": 128}, {"coarse_resolution": 128}, {"sky_lights": 3}):
        made.render()
        made.frame_settings = replace(made.frame_settings, **change)
        fresh = renderer(device, scene(), "none")
        fresh.frame_settings = made.frame_settings
        assert same(made.render(), fresh.render()), change


def test_what_has_come_to_rest_is_said_of_its_vpls(device, monkeypatch):
    """Without a change of the scene, some frames after the last: the traits are a fresh renderer's again."""
    made, frames = renderer(device, scene(), "cascaded-lpv"), []
    update = type(made.technique).update
    monkeypatch.setattr(type(made.technique), "update", lambda self, frame: (frames.append(frame), update(self, frame)))

    def traits(of: Renderer) -> np.ndarray:
        of.render()
        return device.read_texture(frames[-1].vpl_surfaces, np.uint32, 1)

    made.render()
    made.scene = _moved(made.scene)
    found = [traits(made) for _ in range(MOVING_SYNCS + 2)]
    rest = traits(renderer(device, made.scene, "cascaded-lpv"))
    assert [np.array_equal(words, rest) for words in found] == [False] * MOVING_SYNCS + [True] * 2
