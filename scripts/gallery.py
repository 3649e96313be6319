"""Renders every built-in scene from each of its cameras into docs/images/gallery and writes docs/gallery.md:
`.venv/bin/python scripts/gallery.py [NAME ...]`. With names of scenes it makes only their pictures, and the whole page.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

import octolux
from octolux.gpu.device import Device
from octolux.scene.builtin import BUILTIN, description
from octolux.scene.scene import Scene

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "gallery.md"
FOLDER = ROOT / "docs" / "images" / "gallery"
SIZE = (640, 360)
LARGEST = 100_000
"""Bytes of one picture."""

HEAD = """# Gallery

The built-in scenes, each from each of its cameras, rendered with `octree-lpv` at its default settings.
This page and its pictures are made by `.venv/bin/python scripts/gallery.py`.
"""


def main() -> None:
    wanted = sys.argv[1:] or list(BUILTIN)
    device = Device()
    FOLDER.mkdir(parents=True, exist_ok=True)
    scenes = {name: make() for name, make in BUILTIN.items()}
    for name in wanted:
        render(device, name, scenes[name])
    PAGE.write_text(page(scenes), encoding="utf-8")


def render(device: Device, name: str, scene: Scene) -> None:
    """A JPEG of what each camera sees, of the best quality that stays below the largest size."""
    renderer = octolux.Renderer(scene, size=SIZE, anti_aliasing="auto", device=device)
    for camera in scene.cameras:
        picture = Image.fromarray(renderer.render(camera.name).display[..., :3])
        path = FOLDER / file_name(name, camera.name)
        for quality in (90, 85, 80, 70, 60):
            picture.save(path, quality=quality, optimize=True)
            if path.stat().st_size < LARGEST:
                break
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")


def page(scenes: dict[str, Scene]) -> str:
    """The text of docs/gallery.md."""
    return "\n".join([HEAD, *(section(name, scene) for name, scene in scenes.items())])


def section(name: str, scene: Scene) -> str:
    lights = ", ".join(f"`{light.name}`" for light in scene.lights) or "none; its walls glow"
    facts = {
        "triangles": f"{scene.triangle_count:,}",
        "lights": lights,
        "cameras": ", ".join(f"`{camera.name}`" for camera in scene.cameras),
        "animation": animation(scene),
        "exposure": f"{scene.exposure:.1f} EV100",
    }
    rows = [f"| {key} | {value} |" for key, value in facts.items()]
    shots = [shot(name, camera.name) for camera in scene.cameras]
    return "\n".join([f"## {name}", "", description(name), "", "| | |", "|---|---|", *rows, "", *shots])


def animation(scene: Scene) -> str:
    """What moves, and how long, in seconds."""
    if not scene.tracks:
        return "none"
    moving = list(dict.fromkeys(f"{track.target} `{track.name}`" for track in scene.tracks))
    return f"{', '.join(moving)}; {max(float(track.times[-1]) for track in scene.tracks):.3g} s"


def shot(name: str, camera: str) -> str:
    """A picture and the command that renders it."""
    command = f"octolux render {name} --camera {camera} --size {SIZE[0]}x{SIZE[1]} --out {name}.png"
    return f"![{name}, camera {camera}](images/gallery/{file_name(name, camera)})\n\n```sh\n{command}\n```\n"


def file_name(scene: str, camera: str) -> str:
    return f"{scene}-{camera}.jpg"


if __name__ == "__main__":
    main()
