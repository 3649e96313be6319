"""Renders a camera that slides through the atrium, by a tenth of the finest cell a frame, as PNG files, and their
contact sheet into docs/images: `python scripts/clpv_clip.py FOLDER [FRAMES]` (88 frames by default, the path of
`python -m benchmarks clpv_stability_slide`).

Each frame is the picture above the indirect irradiance alone, in which jumps would be seen; the sheet has every
eleventh.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # benchmarks is not installed

from benchmarks.clpv_stability import atrium, slide  # noqa: E402
from benchmarks.lab import device  # noqa: E402
from octolux.renderer import Renderer  # noqa: E402
from octolux.scene.errors import OctoluxError  # noqa: E402
from octolux.simulator.tonemap import display  # noqa: E402
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings  # noqa: E402

SHEET = ROOT / "docs" / "images" / "cascaded-lpv-slide.jpg"
SIZE, COLUMNS, EVERY = (320, 180), 4, 11


def frames(count: int, folder: Path) -> list[np.ndarray]:
    """Write `count` frames and return every EVERYth: picture above irradiance, uint8 (2 * height, width, 3)."""
    renderer = Renderer(atrium(), "cascaded-lpv", size=SIZE, anti_aliasing="fxaa", sequence=True, device=device())
    kept = []
    for number, camera in enumerate(slide(CascadedLpvSettings()).viewers[:count]):
        picture = renderer.render(camera)
        irradiance = display(picture.layers["irradiance"] / np.pi, picture.exposure, "neutral")
        both = np.concatenate([picture.display[..., :3], irradiance])
        Image.fromarray(both).save(folder / f"{number:03d}.png")
        if number % EVERY == 0:
            kept.append(both)
    return kept


def sheet(kept: list[np.ndarray]) -> np.ndarray:
    """The frames in rows of COLUMNS; what is left of the last row is black."""
    left = -len(kept) % COLUMNS
    tiles = [*kept, *[np.zeros_like(kept[0])] * left]
    rows = [np.concatenate(tiles[i : i + COLUMNS], axis=1) for i in range(0, len(tiles), COLUMNS)]
    return np.concatenate(rows)


def main() -> int:
    """Exit code 0, or 2 for wrong arguments or a folder that cannot be made."""
    words = sys.argv[1:]
    if not 1 <= len(words) <= 2 or (len(words) == 2 and not words[1].isdigit()) or words[1:] == ["0"]:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(words[0])
    try:
        folder.mkdir(parents=True, exist_ok=True)
        kept = frames(int(words[1]) if len(words) == 2 else 88, folder)
    except (OSError, OctoluxError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    small = Image.fromarray(sheet(kept))
    small.save(SHEET, quality=80, optimize=True)
    print(f"{SHEET.relative_to(ROOT)}: {SHEET.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
