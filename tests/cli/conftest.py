"""Running the program inside the tests' own process."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from octolux.cli import main


class Run(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """An empty folder, made the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(monkeypatch, capsys) -> Callable[..., Run]:
    """`run("render", "cornell-box")`: exit code and what was printed."""
    monkeypatch.setenv("COLUMNS", "200")

    def call(*words: str) -> Run:
        monkeypatch.setattr(sys, "argv", ["octolux", *words])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(bool(stop.code))
        printed = capsys.readouterr()
        return Run(code, printed.out, printed.err)

    return call


# The smallest render: few pixels, cells, shadow texels and VPLs.
SMALL = ("--size", "16x12", "--shadow-resolution", "64", "--rsm-resolution", "16", "--anti-aliasing", "off")


@pytest.fixture
def render(run) -> Callable[..., Run]:
    """`render("cornell-box", "--out", "a.png")` with small sizes."""
    return lambda scene, *words: run("render", scene, *SMALL, *words)


TWO_CAMERAS = """
exposure = 0.0
[[model]]
file = "cornell-box"
cameras = false
[[camera]]
name = "wide"
position = [0.0, 1.0, 3.9]
look_at = [0.0, 1.0, 0.0]
[[camera]]
name = "red wall"
position = [0.8, 1.0, 0.8]
look_at = [-1.0, 1.0, 0.0]
"""


@pytest.fixture
def two_cameras(tmp_path) -> Path:
    """A TOML scene: the Cornell box with cameras "wide" and "red wall"."""
    path = tmp_path / "two.toml"
    path.write_text(TWO_CAMERAS)
    return path
