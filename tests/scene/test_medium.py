"""Media: what a scene holds of them, from Python and TOML, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from toml_files import load_text, model, write_model

from octolux.scene.errors import SceneError
from octolux.scene.medium import MOST_CELLS, Medium
from octolux.scene.scene import Scene

BOX = {"low": (0.0, 0.0, 0.0), "high": (1.0, 2.0, 3.0)}


def cells(*shape: int, value: float = 1.0, dtype=np.float32) -> np.ndarray:
    return np.full(shape, value, dtype)


# Arguments, place, what the problem contains.
MISTAKES = {
    "negative": ({"scattering": (0.1, -0.1, 0.1)}, "scattering", "holds -0.1"),
    "infinite": ({"absorption": (0.1, float("inf"), 0.1)}, "absorption", "holds inf"),
    "not a number": ({"absorption": (float("nan"), 0.1, 0.1)}, "absorption", "holds nan"),
    "one number": ({"scattering": 0.1}, "scattering", "shape ()"),
    "two numbers": ({"scattering": (0.1, 0.2)}, "scattering", "shape (2,)"),
    "doubles": ({"density": cells(2, 2, 2, dtype=np.float64), **BOX}, "density", "float64"),
    "flat": ({"density": cells(2, 2), **BOX}, "density", "(2, 2)"),
    "no cells": ({"density": cells(2, 0, 2), **BOX}, "density", "(2, 0, 2)"),
    "too many cells": ({"density": cells(1, 1, MOST_CELLS + 1), **BOX}, "density", "2049"),
    "negative density": ({"density": cells(2, 2, 2, value=-1), **BOX}, "density", "negative"),
    "infinite density": ({"density": cells(2, 2, 2, value=np.inf), **BOX}, "density", "not finite"),
    "unknown density": ({"density": cells(2, 2, 2, value=np.nan), **BOX}, "density", "not finite"),
    "density without a box": ({"density": cells(2, 2, 2)}, "low", "missing"),
    "half a box": ({"low": (0.0, 0.0, 0.0)}, "high", "missing"),
    "other half": ({"high": (0.0, 0.0, 0.0)}, "low", "missing"),
    "empty box": ({"low": (0.0, 1.0, 0.0), "high": (1.0, 1.0, 1.0)}, "high", "empty"),
    "box without end": ({"low": (0.0, 0.0, 0.0), "high": (1.0, np.inf, 1.0)}, "high", "not finite"),
    "box to the stars": ({"low": (0.0, 0.0, 0.0), "high": (1.0, 1e10, 1.0)}, "high", "beyond 1e+09 m"),
    "flat box": ({"low": (0.0, 0.0), "high": (1.0, 1.0)}, "high", "empty"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_have_one_error(name):
    arguments, place, problem = MISTAKES[name]
    with pytest.raises(SceneError) as caught:
        Medium(**arguments)
    assert caught.value.place == place and problem in caught.value.problem and caught.value.remedy


def test_extinction_is_both_together():
    np.testing.assert_allclose(Medium(scattering=(1, 2, 3), absorption=(0.5, 0, 1)).extinction, [1.5, 2, 4])


def test_clear_air_by_default():
    assert Scene().medium is None


def test_a_scene_at_a_time_keeps_its_medium():
    medium = Medium(scattering=(1.0, 1.0, 1.0))
    assert Scene(medium=medium).at(1.0).medium is medium


def test_toml(tmp_path):
    scene = load_text(tmp_path, "[medium]\nscattering = 0.05\nabsorption = [0, 0.01, 0.02]\n")
    assert scene.medium.scattering == (0.05,) * 3 and scene.medium.absorption == (0.0, 0.01, 0.02)
    assert scene.medium.density is scene.medium.low is scene.medium.high is None
    assert load_text(tmp_path, "exposure = 1\n").medium is None


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.uint8])
def test_toml_density(tmp_path, dtype):
    np.save(tmp_path / "smoke.npy", np.arange(24).reshape(2, 3, 4).astype(dtype))
    medium = load_text(tmp_path, DENSITY).medium
    assert medium.density.dtype == np.float32 and medium.low == (0, 0, 0) and medium.high == (4, 3, 2)
    np.testing.assert_array_equal(medium.density, np.arange(24).reshape(2, 3, 4))


DENSITY = '[medium]\nscattering = 1\ndensity = "smoke.npy"\nlow = [0, 0, 0]\nhigh = [4, 3, 2]\n'


def test_the_medium_of_a_model_stays_there(tmp_path):
    """As its box may not stand straight where the model is turned."""
    (tmp_path / "inner.toml").write_text("[medium]\nscattering = 1\n[[model]]\nfile = 'cornell-box'\n")
    assert load_text(tmp_path, "[[model]]\nfile = 'inner.toml'\n").medium is None


# TOML text, place, what the problem contains.
TOML_MISTAKES = {
    "list for a table": ("[[medium]]\nscattering = 1\n", "medium", "a table"),
    "unknown key": ("[medium]\nscatering = 1\n", "[medium]: scatering", "no such key"),
    "negative": ("[medium]\nscattering = -1\n", "[medium]: scattering", "holds -1"),
    "not finite": ("[medium]\nabsorption = inf\n", "[medium]: absorption", "not finite"),
    "two numbers": ("[medium]\nabsorption = [1, 2]\n", "[medium]: absorption", "3 numbers"),
    "missing file": (DENSITY, "[medium]: density", "no file"),
    "a folder": (DENSITY.replace("smoke.npy", "."), "[medium]: density", "cannot be read"),
    "no array": (DENSITY.replace("smoke.npy", "model.obj"), "[medium]: density", "is no array"),
    "an empty file": (DENSITY.replace("smoke.npy", "empty.npy"), "[medium]: density", "is no array"),
    "a cut file": (DENSITY.replace("smoke.npy", "cut.npy"), "[medium]: density", "is no array"),
    "objects": (DENSITY.replace("smoke.npy", "objects.npy"), "[medium]: density", "is no array"),
    "complex": (DENSITY.replace("smoke.npy", "complex.npy"), "[medium]: density", "holds complex"),
    "flat": (DENSITY.replace("smoke.npy", "flat.npy"), "[medium]: density", "(3, 3)"),
    "too large": (DENSITY.replace("smoke.npy", "large.npy"), "[medium]: density", "not finite"),
    "no box": ('[medium]\ndensity = "good.npy"\n', "[medium]: low", "missing"),
    "empty box": (DENSITY.replace("smoke", "good").replace("4, 3, 2", "4, 0, 2"), "[medium]: high", "empty"),
}


@pytest.mark.parametrize("name", TOML_MISTAKES)
def test_toml_mistakes_have_one_error(tmp_path, name):
    write_model(tmp_path)
    arrays = {
        "objects": np.array([{}], dtype=object), "complex": cells(2, 2, 2, dtype=np.complex64), "flat": cells(3, 3),
        "large": cells(2, 2, 2, value=1e300, dtype=np.float64), "good": cells(2, 2, 2), "cut": cells(20, 20, 20),
    }  # fmt: skip
    for file, array in arrays.items():
        np.save(tmp_path / f"{file}.npy", array, allow_pickle=True)
    (tmp_path / "empty.npy").write_bytes(b"")
    (tmp_path / "cut.npy").write_bytes((tmp_path / "cut.npy").read_bytes()[:500])
    text, place, problem = TOML_MISTAKES[name]
    with pytest.raises(SceneError) as caught:
        load_text(tmp_path, text + model())
    assert caught.value.place == place, caught.value
    assert problem in caught.value.problem and caught.value.remedy
    assert caught.value.file == str(tmp_path / "scene.toml")
