"""The benchmark scenes: TOML files of benchmarks/scenes, whose models lie in the data folder."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import octolux
from octolux.scene.scene import Scene

from .lab import data

SCENES = Path(__file__).parent / "scenes"
_MODELS = {"cornell_point": "cornell-box", "cornell_area": "cornell-box", "sponza_sunpoint": "dabrovic-sponza",
           "crytek_sponza": "crytek-sponza", "crytek_lamps": "crytek-sponza", "moving_fox": "gltf/Fox"}


def path_of(name: str) -> Path:
    """The TOML file of a benchmark scene. Raises NeedsData when its model is not there."""
    data("scenes", _MODELS[name])
    return SCENES / f"{name}.toml"


@cache
def load(name: str) -> Scene:
    """The scene, loaded once. Raises NeedsData when its model is not there."""
    return octolux.load(path_of(name))
