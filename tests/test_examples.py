"""Every example runs, and the README shows what is run."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import octolux

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_example(example, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(example), run_name="__main__")
    assert capsys.readouterr().out
    for picture in tmp_path.glob("*.png"):
        assert Image.open(picture).convert("L").getextrema()[1] > 0


def test_change_a_light_scales_each_channel(tmp_path, monkeypatch, device):
    """Light is linear: direct light changes by the channel's share of the lamp's former 60 cd, and so does the flux of
    all that reflects it. (Where a node's light stands follows its colour a little, so indirect light is linear in
    brightness alone: tests/images/test_techniques.py.)"""
    monkeypatch.chdir(tmp_path)
    picture = runpy.run_path(str(ROOT / "examples" / "change_a_light.py"))["picture"]
    former = octolux.Renderer(octolux.load("cornell-box"), size=(640, 480), device=device).render()
    factor = np.array([80.0, 50.0, 25.0]) / 60.0
    np.testing.assert_allclose(picture.layers["direct"], former.layers["direct"] * factor, rtol=1e-5)
    gained = picture.layers["indirect"].mean(axis=(0, 1)) / former.layers["indirect"].mean(axis=(0, 1))
    assert gained[0] > 1.0 > gained[1] > gained[2]


def test_readme_shows_the_example():
    program = (ROOT / "examples" / "change_a_light.py").read_text().split('"""', 2)[2].strip()
    assert f"```python\n{program}\n```" in (ROOT / "README.md").read_text()
