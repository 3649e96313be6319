"""The documents say what the code says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import octolux
from octolux.gpu.device import Device
from octolux.scene.load import LOADERS
from octolux.techniques import TECHNIQUES
from octolux.techniques.document import settings_table

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])


@pytest.mark.parametrize("name", [name for name in TECHNIQUES if name not in ("none", "constant")])
def test_each_technique_has_a_page_with_its_settings(name):
    page = (ROOT / "docs" / "techniques" / f"{name}.md").read_text(encoding="utf-8")
    hint = f"put in what `python -m octolux.techniques.document {name}` prints"
    assert settings_table(name) in page, hint


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_and_named_files_exist(page):
    """Relative links, and files of the package that the page names in code quotes such as `frame/rsm.py`."""
    text = page.read_text(encoding="utf-8")
    links = [link.split("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    missing = [link for link in links if link and not (page.parent / link).exists()]
    named = re.findall(r"`([\w./]+/[\w.]+\.(?:py|wgsl|sh|toml|md))`", text)
    missing += [name for name in named if not any((root / name).exists() for root in (ROOT, ROOT / "octolux"))]
    assert not missing


def test_models_lists_every_extension():
    page = (ROOT / "docs" / "models.md").read_text(encoding="utf-8")
    rows = "".join(line.partition(" | ")[0] for line in page.splitlines() if line.startswith("| `."))
    assert set(re.findall(r"`(\.\w+)`", rows)) == set(LOADERS) - {".toml"}


def test_conventions_list_every_layer_and_statistic(device: Device):
    page = (ROOT / "docs" / "conventions.md").read_text(encoding="utf-8")
    renderer = octolux.Renderer(octolux.load("furnace"), "none", size=(8, 8), device=device)
    names = [*renderer.render().layers, *renderer.statistics(), "energy"]
    assert not [name for name in names if f"`{name}`" not in page]
