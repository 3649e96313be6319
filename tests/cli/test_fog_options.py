"""`octolux render --fog`."""

from __future__ import annotations

import json

import numpy as np
import pytest

FOG = ("--technique", "none", "--out", "a.npz")


def layers(folder):
    with np.load(folder / "a.npz") as held:
        return dict(held)


def test_fog_is_in_the_layers(render, folder):
    done = render("cornell-box", *FOG, "--fog", "0.1")
    assert done.code == 0 and "warning" not in done.err, done.err
    foggy = layers(folder)
    seen = foggy["depth"] > 0
    assert 0 < foggy["transmittance"].min() < foggy["transmittance"][seen].max() < 1 and foggy["fog"][seen].min() > 0
    np.testing.assert_allclose(
        foggy["radiance"], (foggy["direct"] + foggy["indirect"]) * foggy["transmittance"] + foggy["fog"], rtol=1e-5
    )
    assert "fog" in done.out
    assert render("cornell-box", *FOG).code == 0
    clear = layers(folder)
    assert not clear["fog"].any() and np.all(clear["transmittance"] == 1)


def test_three_numbers_and_absorption(render, folder):
    """T^(1 / extinction) is the same in each channel."""
    done = render("cornell-box", *FOG, "--fog", "0.1,0.2,0.4", "--fog-absorption", "0.1", "--fog-resolution", "1")
    assert done.code == 0, done.err
    depth = -np.log(layers(folder)["transmittance"].astype(np.float64)) / [0.2, 0.3, 0.5]
    np.testing.assert_allclose(depth, depth[..., :1] * np.ones(3), rtol=1e-4)


def test_smoke_that_only_absorbs(render, folder):
    assert render("cornell-box", *FOG, "--fog-absorption", "0.5").code == 0
    smoky = layers(folder)
    assert not smoky["fog"].any() and smoky["transmittance"][smoky["depth"] > 0].max() < 1


@pytest.mark.parametrize("words", [
    ("--fog", "-1"), ("--fog", "thick"), ("--fog", "1,2"), ("--fog", "nan"), ("--fog", "inf"), ("--fog", ""),
    ("--fog-absorption", "1,2,x"), ("--fog", "1", "--fog-resolution", "3"),
])  # fmt: skip
def test_wrong_fog_is_one_line(render, folder, words):
    done = render("cornell-box", *FOG, *words)
    assert done.code == 2 and done.err.startswith("error: ") and done.err.count("\n") == 1
    assert words[-2].strip("-").replace("-", "_") in done.err.replace("-", "_")
    assert not any(folder.iterdir())


def test_the_path_tracer_says_that_it_leaves_fog_out(render, folder):
    done = render("cornell-box", "--technique", "path-tracer", "--samples", "1", "--fog", "0.1", "--out", "a.npz")
    assert done.code == 0 and "warning: the technique path-tracer knows no media" in done.err
    assert np.all(layers(folder)["transmittance"] == 1)


SCENE = """
[medium]
scattering = 0.1
density = "smoke.npy"
low = [-1, 0, -1]
high = [1, 2, 1]
[[model]]
file = "cornell-box"
"""


@pytest.fixture
def smoky(folder):
    np.save(folder / "smoke.npy", np.linspace(0, 1, 24).reshape(2, 3, 4))
    (folder / "smoky.toml").write_text(SCENE)


def test_a_medium_of_a_file(render, folder, smoky):
    assert render("smoky.toml", *FOG).code == 0
    held = layers(folder)
    assert held["fog"].any() and held["transmittance"].min() < 1


def test_info_tells_of_a_medium(run, smoky):
    done = run("info", "smoky.toml")
    assert "medium: scatters (0.1, 0.1, 0.1), absorbs (0, 0, 0) 1/m, density of 4 x 3 x 2 cells" in done.out
    assert "medium" not in run("info", "cornell-box").out
    facts = json.loads(run("info", "smoky.toml", "--json").out)["medium"]
    assert facts["cells"] == [4, 3, 2] and facts["low"] == [-1, 0, -1] and facts["high"] == [1, 2, 1]


def test_export_leaves_the_medium_out_and_says_so(run, smoky):
    assert "the medium is left out" in run("export", "smoky.toml", "out.xml").err
