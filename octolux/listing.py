"""What there is: techniques with their settings, and built-in scenes, as the program lists them."""

from __future__ import annotations

import dataclasses
from typing import Any

from .scene.builtin import BUILTIN, description
from .techniques import TECHNIQUES
from .techniques.settings import Form, allowed_text


def techniques() -> list[dict[str, Any]]:
    """Every technique as its class declares it: name, summary, presets, settings. Plain data, for JSON."""
    return [
        {
            "name": name,
            "summary": technique.summary,
            "presets": {"default": {}, **technique.settings_class.PRESETS},
            "settings": [_setting(field) for field in dataclasses.fields(technique.settings_class)],
        }
        for name, technique in TECHNIQUES.items()
    ]


def _setting(field: dataclasses.Field) -> dict[str, Any]:
    about = field.metadata
    return {
        "name": field.name,
        "default": field.default,
        "meaning": about["meaning"],
        "unit": about["unit"],
        "allowed": _allowed(about["allowed"]),
        "cost": about["cost"],
        "source": about["source"],
    }


def _allowed(allowed: Any) -> dict[str, Any]:
    if isinstance(allowed, Form):
        return {"form": allowed.text}
    return {"one_of": list(allowed)} if isinstance(allowed, tuple) else {"from": allowed[0], "to": allowed[1]}


def technique_lines() -> list[str]:
    """The same for people."""
    lines = []
    for name, technique in TECHNIQUES.items():
        lines += [f"{name}: {technique.summary}"]
        lines += [f"  presets: {', '.join(['default', *technique.settings_class.PRESETS])}"]
        for field in dataclasses.fields(technique.settings_class):
            about = field.metadata
            allowed = allowed_text(about["allowed"], about["unit"])
            lines += [f"  {field.name} = {field.default}: {about['meaning']} ({allowed})"]
            lines += [f"      cost: {about['cost']}; source: {about['source']}"]
    return lines


def scene_lines() -> list[str]:
    """The built-in scenes: what they show, how large they are, what one may choose."""
    return [line for name in BUILTIN for line in _scene(name)]


def _scene(name: str) -> list[str]:
    scene = BUILTIN[name]()
    cameras = ", ".join(camera.name for camera in scene.cameras)
    moves = f", moves for {scene.duration:.3g} s" if scene.duration else ""
    return [f"{name}: {description(name)}", f"    {scene.triangle_count} triangles, cameras {cameras}{moves}"]
