"""Pictures of docs/simulate.md that show the page and flatland: python scripts/simulate_page_images.py

Needs chromium and the extra `ui`. The page is driven as in the tests.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "images"
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "tests" / "viewer")]

from pages import opened  # noqa: E402

from octolux.simulator.flatland.results import flatland_files  # noqa: E402
from octolux.simulator.laboratory import Simulation  # noqa: E402
from octolux.simulator.laboratory.script import Script  # noqa: E402


def two_walls() -> Simulation:
    """What examples/simulate/two-walls.toml makes."""
    script = Script(ROOT / "examples" / "simulate" / "two-walls.toml")
    script.run()
    return script.simulation


def save(png: bytes, name: str, width: int) -> None:
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    small = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
    small.save(FOLDER / f"{name}.jpg", quality=85, optimize=True)


def main() -> None:
    """Write both."""
    files, _ = flatland_files()
    save(files["flatland.png"], "simulate-flatland", 1400)
    with TemporaryDirectory() as folder, opened(two_walls, Path(folder)) as page:
        page.browser.resize(1580, 1090)
        page.click("scale", "button:last-child", says="looking at")
        page.browser.mouse("Moved", 1400, 250)
        page.until("new Promise(done => setTimeout(() => done(true), 1000))")
        save(page.browser.picture(whole=False), "simulate-page", 1200)


if __name__ == "__main__":
    main()
