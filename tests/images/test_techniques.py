"""What every technique owes to those who read it: settings that explain themselves, memory, debug views."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import octolux
from octolux.frame.visibility import draw_list
from octolux.techniques import TECHNIQUES

_LIGHT_STAGES = {"shadow maps", "RSM rendering", "RSM surfaces"}


@pytest.mark.parametrize("name", TECHNIQUES)
def test_settings_explain_themselves(name):
    for field in dataclasses.fields(TECHNIQUES[name].settings_class):
        assert {"meaning", "unit", "allowed", "cost", "source"} <= field.metadata.keys()
        assert all(field.metadata[key] for key in ("meaning", "allowed", "cost", "source")), field.name


@pytest.mark.parametrize("name", TECHNIQUES)
def test_every_preset_makes_settings_and_survives_text(name):
    settings_class = TECHNIQUES[name].settings_class
    for preset in ("default", *settings_class.PRESETS):
        made = settings_class.make(preset)
        texts = {key: str(value) for key, value in made.as_dict().items()}
        assert settings_class.from_strings("default", texts) == made


def test_memory_of_the_volume_is_that_of_its_cells(device):
    n, pixels = 16, 64 * 48
    renderer = octolux.Renderer(
        octolux.load("cornell-box"), "uniform-lpv", settings={"n": n}, size=(64, 48), device=device
    )
    before = renderer.technique.memory()
    renderer.render()
    held = renderer.technique.memory()
    # Other renderers of the session's device may hold volumes too: count what this one added or more.
    assert held["LPV cells"] >= 2 * (n + 2) ** 3 * 3 * 16
    assert held["LPV volumes"] >= 3 * n**3 * 8
    assert held["LPV irradiance"] - before.get("LPV irradiance", 0) == pixels * 16


def test_debug_views_are_the_volume(device):
    renderer = octolux.Renderer(
        octolux.load("cornell-box"), "uniform-lpv", settings={"n": 16}, size=(64, 48), device=device
    )
    renderer.render()
    views = renderer.technique.debug_views()
    assert all(view.shape == (16, 16, 16, 3, 4) for view in views.values())
    # The sum begins with what was injected, and light is never negative.
    assert (views["accumulated"][..., 0] >= views["injected"][..., 0] * (1 - 1e-6)).all()
    assert np.isfinite(views["accumulated"]).all() and views["injected"][..., 0].max() > 0


@pytest.mark.parametrize("name", ["uniform-lpv", "octree-lpv"])
def test_twice_the_light_is_twice_the_irradiance(device, name):
    """In the same bits: all scales are powers of two."""
    scene, found = octolux.load("cornell-box"), []
    for times in (1.0, 2.0):
        lit = dataclasses.replace(scene, exposure=0.0)
        lit.lights = [dataclasses.replace(x, intensity=tuple(times * i for i in x.intensity)) for x in scene.lights]
        picture = octolux.Renderer(lit, name, settings={"n": 16}, size=(64, 48), device=device).render()
        found.append(picture.layers["irradiance"])
    assert found[0].max() > 0
    np.testing.assert_array_equal(2.0 * found[0], found[1])


@pytest.mark.parametrize(("name", "expected"), [
    ("path-tracer", set()), ("none", {"shadow maps"}), ("uniform-lpv", {"RSM rendering", "RSM surfaces"}),
])  # fmt: skip
def test_only_the_passes_that_a_technique_asks_for(device, name, expected, monkeypatch):
    """Shadow maps where direct light is rasterised, RSMs where VPLs are injected; what no map shows is not culled."""
    culled = []

    def counted(scene, views, **rest):
        culled.append(len(views))
        return draw_list(scene, views, **rest)

    monkeypatch.setattr("octolux.renderer.draw_list", counted)
    scene = octolux.load("cornell-box")
    few = {"samples": 1} if name == "path-tracer" else {}
    renderer = octolux.Renderer(scene, name, settings=few, size=(16, 12), device=device, profile=True, exposure=0.0)
    picture = renderer.render()
    assert {stage["name"] for stage in renderer.statistics()["stages"]} & _LIGHT_STAGES == expected
    assert picture.radiance.any()
    assert (culled[0] > 1) == bool(expected)
