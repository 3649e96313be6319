"""A technique's settings and presets as Markdown, for its page: `python -m octolux.techniques.document uniform-lpv`."""

from __future__ import annotations

import dataclasses
import sys
from typing import Any

from ..scene.errors import OctoluxError
from . import technique_class
from .settings import allowed_text


def settings_table(name: str) -> str:
    """Every setting of technique `name` in every preset, as two Markdown tables. Raises SettingsError."""
    settings_class = technique_class(name).settings_class
    presets = {preset: settings_class.from_strings(preset).as_dict() for preset in ("default", *settings_class.PRESETS)}
    fields = dataclasses.fields(settings_class)
    values = [[f"`{f.name}`", *(_value(preset[f.name]) for preset in presets.values())] for f in fields]
    about = [[f"`{f.name}`", *_about(f.metadata)] for f in fields]
    return (
        _table(["setting", *(f"`{preset}`" for preset in presets)], values)
        + "\n"
        + _table(["setting", "meaning", "allowed", "what more or less of it costs", "source"], about)
    )


def _about(metadata: Any) -> list[str]:
    allowed = allowed_text(metadata["allowed"], metadata["unit"])
    return [metadata["meaning"], allowed, metadata["cost"], metadata["source"]]


def _value(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)


def main() -> None:
    try:
        for name in sys.argv[1:]:
            print(settings_table(name), end="")
    except OctoluxError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
