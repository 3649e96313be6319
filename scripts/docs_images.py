"""Renders the pictures of README and docs into docs/images: `.venv/bin/python scripts/docs_images.py`.

The comparisons with path-traced pictures need the data folder (OCTOLUX_DATA) and are left alone without it.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import octolux
from octolux.data import data_folder
from octolux.gpu.device import Device
from octolux.techniques import technique_class

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "images"


def save(name: str, columns: list[np.ndarray]) -> None:
    """uint8 pictures side by side, as JPEG."""
    path = FOLDER / f"{name}.jpg"
    Image.fromarray(np.concatenate([c[..., :3] for c in columns], axis=1)).save(path, quality=88, optimize=True)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


def display(device: Device, scene: str, technique: str, size: tuple[int, int]) -> np.ndarray:
    return octolux.Renderer(octolux.load(scene), technique, size=size, anti_aliasing=8, device=device).render().display


def against_reference(device: Device, name: str) -> None:
    """Indirect light of each preset, and last the path-traced first bounce, all with the same exposure."""
    file = data_folder() / "ground-truth" / f"{name}.npz"
    if not file.is_file():
        print(f"{name}: left alone, {file} is not there")
        return
    truth = np.load(file)
    height, width = truth["mask"].shape
    settings_class = technique_class("uniform-lpv").settings_class
    pictures = []
    for preset in ("default", "paper", "thesis"):
        renderer = octolux.Renderer(
            octolux.load(ROOT / "benchmarks" / "scenes" / f"{name}.toml"),
            settings=settings_class.from_strings(preset), size=(width, height), device=device,
        )  # fmt: skip
        pictures.append(renderer.render().layers["indirect"])
    pictures.append(truth["first_bounce"])
    white = 4.0 * float(truth["first_bounce"][truth["mask"]].mean())
    encoded = [np.clip(picture / white, 0, 1) ** (1 / 2.2) for picture in pictures]
    save(f"uniform-lpv-{name}", [(255 * picture + 0.5).astype(np.uint8) for picture in encoded])


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    device = Device()
    save("atrium", [display(device, "atrium", "uniform-lpv", (1280, 720))])
    save("cornell-box", [display(device, "cornell-box", t, (480, 480)) for t in ("none", "uniform-lpv")])
    for name in ("cornell_point", "sponza_sunpoint"):
        against_reference(device, name)


if __name__ == "__main__":
    main()
