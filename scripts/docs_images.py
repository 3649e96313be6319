"""Renders the pictures of README and docs into docs/images: `.venv/bin/python scripts/docs_images.py`.

Those of techniques beside their references are made by scripts/technique_images.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

import octolux
from octolux.gpu.device import Device
from octolux.scene.medium import Medium
from octolux.simulator.tonemap import srgb_encode

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "docs" / "images"


def save(name: str, columns: list[np.ndarray]) -> None:
    """uint8 pictures side by side, as JPEG."""
    path = FOLDER / f"{name}.jpg"
    Image.fromarray(np.concatenate([c[..., :3] for c in columns], axis=1)).save(path, quality=88, optimize=True)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


def display(device: Device, scene: str, technique: str, size: tuple[int, int]) -> np.ndarray:
    return octolux.Renderer(octolux.load(scene), technique, size=size, anti_aliasing=8, device=device).render().display


def fog(device: Device) -> np.ndarray:
    """The picture of docs/rendering.md, "Fog"."""
    scene = octolux.load("atrium")
    scene.medium = Medium(scattering=(0.08, 0.08, 0.08))
    eye = octolux.Camera.look_at((9.5, 2.0, -0.8), (-6.0, 3.2, 1.5), vertical_fov=1.13)
    return octolux.Renderer(scene, size=(960, 540), anti_aliasing=8, exposure=12.0, device=device).render(eye).display


def debug_views(device: Device, *names: str) -> list[np.ndarray]:
    """Pictures of docs/techniques/voxel-cones.md, "Debug views", of the atrium."""
    renderer = octolux.Renderer(octolux.load("atrium"), "voxel-cones", size=(480, 270), device=device)
    renderer.render()
    return [np.round(255.0 * srgb_encode(renderer.technique.debug_views()[name])).astype(np.uint8) for name in names]


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    device = Device()
    save("atrium", [display(device, "atrium", "octree-lpv", (1280, 720))])
    save("fog-atrium", [fog(device)])
    save("voxel-cones-voxels", debug_views(device, "voxels:0:albedo", "voxels:2:light"))
    save("voxel-cones-cones", debug_views(device, "cones:drawn:100:60", "voxels:2:opacity"))
    save("cornell-box", [display(device, "cornell-box", t, (480, 480)) for t in ("none", "octree-lpv")])


if __name__ == "__main__":
    main()
