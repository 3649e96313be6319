"""The gallery shows what is built in."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image

from octolux.scene.builtin import BUILTIN, description

DOCS = Path(__file__).resolve().parent.parent / "docs"
TEXT = (DOCS / "gallery.md").read_text(encoding="utf-8")
SECTIONS = {part.split("\n", 1)[0]: part for part in TEXT.split("\n## ")[1:]}
HINT = "run scripts/gallery.py"


def test_gallery_lists_exactly_the_built_in_scenes():
    assert list(SECTIONS) == list(BUILTIN), HINT


@pytest.mark.parametrize("name", BUILTIN)
def test_gallery_tells_and_shows_each_scene(name):
    scene, text = BUILTIN[name](), SECTIONS[name]
    assert description(name) in text, HINT
    assert f"| triangles | {scene.triangle_count:,} |" in text, HINT
    assert re.findall(r"!\[.*camera (.*)\]", text) == [camera.name for camera in scene.cameras], HINT
    assert all(f"`{light.name}`" in text for light in scene.lights), HINT
    assert all(f"`{track.name}`" in text for track in scene.tracks), HINT


@pytest.mark.parametrize("link", re.findall(r"\]\((images/[^)]+)\)", TEXT))
def test_gallery_pictures_are_small_and_show_something(link):
    """Only a room that is dark in truth may be black. The darkest of the others, the furnace, is at 56."""
    path = DOCS / link
    assert path.stat().st_size < 100_000
    picture = Image.open(path)
    assert picture.size == (640, 360)
    if "two-rooms-dark" not in link:
        assert picture.convert("L").getextrema()[1] > 50
