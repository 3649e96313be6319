"""Renders figures of Kaplanyan and Dachsbacher 2010 anew: `python scripts/clpv_figures.py [6|7|11|12]`, in docs/images.

6: Crytek Sponza without textures: direct light; with three cascades; with the path-traced first bounce; and the
signed difference of the last two, green where the cascades are too bright and red where they are too dark, full
colour from the traced light's mean on. 7: one grid of 32^3 without occlusion, with it, and with bounces; above the
paper's steps, below the default. 11: indirect light with surfels of one layer that the lamp sees, of two, of the whole
scene, and path-traced. 12: above, one grid of 30, 60, 80 and 100 m for a scene of 37 m; below, 1, 4, 8 and 16
iterations without occlusion. But for 11 all have the sun alone, and need the data folder. The traced light of 6 is kept
in the user's cache folder.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
from paper_figures import save  # also finds benchmarks, which is not installed

from benchmarks.clpv_table1 import base_scene
from benchmarks.lab import device
from benchmarks.olpv_scene import SCENES
from octolux.compare.choices import choice
from octolux.compare.metrics import brightness_map
from octolux.compare.rendering import Rendering, Studio, black
from octolux.frame.frame import FrameSettings
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.images.cache import cache_folder, content_key
from octolux.scene.lights import SpotLight
from octolux.scene.materials import Image as Texels
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.tonemap import display

MAPS = FrameSettings(sky_lights=0, emitter_lights=0)
# EV100, without textures and with: indirect light is seen, and the sunlit floor is white, as in the paper. FAINT: of a
# lamp's indirect light alone.
BRIGHT, DIM = 9.5, 8.5
FAINT = -1.5
ALBEDO = 0.7
BLOCK = 5
TRACED = "path-tracer:reference,materials=diffuse,paths=first-bounce,samples=256"

# CLPV 6, table 1 and figure 7, and ours; screen-space occlusion would hide what the geometry volume does.
GRID = "cascaded-lpv:{preset},cascades=1,ambient_occlusion=false,"
KINDS = ("occlusion=false,bounces=1", "bounces=1", "bounces=2")
EDGES, ITERATIONS = (30, 60, 80, 100), (1, 4, 8, 16)


def untextured(scene: Scene) -> Scene:
    """All surfaces of one albedo; what is cut out stays so."""
    return replace(scene, materials=[_plain(material) for material in scene.materials])


def _plain(material: Material) -> Material:
    texture = material.base_color_texture if material.alpha_mode == "mask" else None
    if texture:
        pixels = texture.image.pixels.copy()
        pixels[..., :3] = 255
        texture = replace(texture, image=Texels(pixels))
    return Material(name=material.name, base_color=(ALBEDO,) * 3, base_color_texture=texture, specular=0.0,
                    alpha_mode=material.alpha_mode if texture else "opaque", alpha_cutoff=material.alpha_cutoff,
                    double_sided=material.double_sided)  # fmt: skip


def studio(scene: Scene, size: tuple[int, int], exposure: float = DIM) -> Studio:
    return Studio(scene, device(), size, SCENES["crytek"], exposure=exposure, frame_settings=MAPS, frames=0)


def traced(scene: Studio) -> np.ndarray:
    """Indirect light of the path-traced first bounce, nits (height, width, 3); kept for the next time."""
    folder = cache_folder()
    path = folder / f"clpv-figure-6-{content_key(TRACED, str(scene.size))}.npy" if folder else None
    if path and path.exists():
        return np.load(path)
    found = scene.render(choice(TRACED)).pictures["indirect"]
    if path:
        path.parent.mkdir(parents=True, exist_ok=True)
        np.save(path, found)
    return found


def signed(found: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """uint8 picture: green where `found` is too bright, red where it is too dark; means of blocks of pixels, which
    have less of the traced light's noise."""
    difference = brightness_map(found, truth, mask)
    height, width = difference.shape
    blocks = difference.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK).mean(axis=(1, 3))
    difference = np.clip(np.kron(blocks, np.ones((BLOCK, BLOCK))), -1.0, 1.0)
    colours = np.stack([np.maximum(-difference, 0.0), np.maximum(difference, 0.0), np.zeros_like(difference)], axis=-1)
    return (255.0 * colours + 0.5).astype(np.uint8)


def shown(rendering: Rendering, exposure: float = DIM) -> np.ndarray:
    return display(rendering.pictures["final"], exposure)


def figure_6() -> np.ndarray:
    scene = studio(untextured(base_scene("crytek")), (480, 270), BRIGHT)
    dark, lit, truth = scene.render(black()), scene.render(choice("cascaded-lpv:default,bounces=1")), traced(scene)
    reference = display(dark.pictures["final"] + truth, BRIGHT)
    difference = signed(lit.pictures["indirect"], truth, dark.mask)
    return _rows([[shown(dark, BRIGHT), shown(lit, BRIGHT)], [reference, difference]])


def figure_7() -> np.ndarray:
    scene = studio(base_scene("crytek"), (400, 225))
    words = [[GRID.format(preset=preset) + kind for kind in KINDS] for preset in ("paper", "default")]
    return _rows([[shown(scene.render(choice(text))) for text in row] for row in words])


def boxes() -> Scene:
    """A lamp lights a red wall at its left; the right one of two boxes stands in the shadow of the other."""
    floor, wall = ((-3, 0, 3), (4, 0, 3), (4, 0, -6), (-3, 0, -6)), ((-3, 0, 3), (-3, 0, -6), (-3, 4, -6), (-3, 4, 3))
    before, backmost = box((-0.8, 0, 0.5), (0.8, 1.8, 1)), box((-0.7, 0, -2), (0.5, 1.1, -0.9))
    meshes = [quad(floor), quad(wall, material=1), before, backmost]
    materials = [Material(base_color=color, specular=0.0) for color in ((ALBEDO,) * 3, (ALBEDO, 0.2, 0.1))]
    lamp = SpotLight(position=(0.0, 1.6, 5.0), direction=(-0.25, -0.1, -1.0), intensity=(400.0,) * 3, outer_angle=0.6)
    return Scene(meshes=meshes, materials=materials, instances=[Instance(k) for k in range(4)], lights=[lamp])


def figure_11() -> np.ndarray:
    eye = Camera.look_at((4.5, 3.0, 1.5), (0.3, 0.3, -1.4), vertical_fov=0.8)
    scene = Studio(boxes(), device(), (320, 180), eye, exposure=FAINT, frame_settings=MAPS, frames=0)
    way = GRID.format(preset="default") + "bounces=1,glossy=false,"
    texts = [*(f"{way}{changes}" for changes in ("surfels=lamps", "surfels=lamps,layers=2", "surfels=scene")), TRACED]
    return _rows([[display(scene.render(choice(text)).pictures["indirect"], FAINT) for text in texts]])


def figure_12() -> np.ndarray:
    scene = studio(base_scene("crytek"), (320, 180))
    paper = GRID.format(preset="paper")
    above = [f"{paper}bounces=1,spacing={edge}" for edge in EDGES]
    below = [f"{paper}occlusion=false,iterations={k}" for k in ITERATIONS]
    return _rows([[shown(scene.render(choice(text))) for text in row] for row in (above, below)])


def _rows(pictures: list[list[np.ndarray]]) -> np.ndarray:
    return np.concatenate([np.concatenate(row, axis=1) for row in pictures], axis=0)


FIGURES = {"6": figure_6, "7": figure_7, "11": figure_11, "12": figure_12}

if __name__ == "__main__":
    sys.exit(save(FIGURES, "clpv-figure-", ""))
