"""Makes the pictures of docs/simulate.md from its examples: `.venv/bin/python scripts/simulate_images.py`."""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

from octolux.simulator.laboratory.results import final_files
from octolux.simulator.laboratory.script import Script

ROOT = Path(__file__).resolve().parent.parent
WIDTH = 1000

# By example: the pictures of it that are shown, and whether beside one another.
SHOWN = {
    "two-walls": (["log.png"], False),
    "errors": (["errors.png"], False),
    "back-bleeding": ([f"iteration-{k}.png" for k in (1, 2, 3)], True),
    "level-borders": (["injected.png"], False),
    "shadow": (["shadow.png"], False),
}


def joined(pictures: list[Image.Image], beside: bool) -> Image.Image:
    """One picture of several, from left to right or from top to bottom."""
    widths, heights = [p.width for p in pictures], [p.height for p in pictures]
    size = (sum(widths), max(heights)) if beside else (max(widths), sum(heights))
    result = Image.new("RGB", size, "white")
    x = y = 0
    for picture in pictures:
        result.paste(picture, (x, y))
        x, y = (x + picture.width, 0) if beside else (0, y + picture.height)
    return result


for name, (files, beside) in SHOWN.items():
    script = Script(ROOT / "examples" / "simulate" / f"{name}.toml")
    made = {**script.run(), **final_files(script.simulation)}
    whole = joined([Image.open(io.BytesIO(made[file])).convert("RGB") for file in files], beside)
    small = whole.resize((WIDTH, round(whole.height * WIDTH / whole.width)), Image.Resampling.LANCZOS)
    small.save(ROOT / "docs" / "images" / f"simulate-{name}.jpg", quality=82, optimize=True)
    print(name)
