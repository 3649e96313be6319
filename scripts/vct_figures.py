"""Renders tables of pictures and a figure of Drinovsky 2013 anew into docs/images:
`python scripts/vct_figures.py [16|17|18|19|20|1]`.

Rows are views of the comparison set; the last column is path-traced, but for table 6.16's, which has it before the
ambient visibility. 16: direct light; all light; ambient visibility. 17: indirect light, a stop brighter, of voxels that
keep it along six axes, and as lobes. 18: all light by octrees of depth 6 to 9. 19: indirect light by 4, 6, 9 and 16
cones. 20: ambient visibility by octrees of depth 6 to 9. 1, its figure 6.1: light in the voxels of a curtain, indirect
light of lobes, and along axes. They need the data folder.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from clpv_figures import ALBEDO, untextured
from paper_figures import save  # also finds benchmarks, which is not installed

from benchmarks import comparison, scenes_on_disk
from benchmarks.comparison_set import VIEWS, View, reference, scene_of
from benchmarks.lab import device
from octolux.compare.choices import choice
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.scene import Scene
from octolux.simulator.tonemap import signal, srgb_encode
from octolux.techniques.voxel_cones.technique import VoxelCones

TECHNIQUE = "voxel-cones:full,screen=0"
LIT = ("cornell_point", "corridor", "atrium", "crytek_sun")
OPEN = ("cornell_point", "atrium", "crytek_sun")
"""Where something is seen of the sky."""
DEPTHS, CONES = (6, 7, 8, 9), (4, 6, 9, 16)
SIZE, PATHS = (256, 144), 64
CURTAIN = Camera.look_at((0.0, 3.0, 0.0), (1.5, 3.2, 5.0), vertical_fov=np.radians(60.0))
"""Of Crytek Sponza: thin, and lit on one side."""


def light(view: View, words: str, whole: bool) -> np.ndarray:
    """uint8: all light with several bounces, or of one the indirect light alone, a stop brighter."""
    found = comparison.picture(view, choice(f"{TECHNIQUE},bounces={4 if whole else 1},{words}"))
    indirect = comparison.diffuse_indirect(found)
    return shown(view, found.pictures["direct"] + indirect) if whole else shown(view, indirect, 1.0)


def truth(view: View, whole: bool) -> np.ndarray:
    """The same by path tracing."""
    if not whole:
        return shown(view, reference(view).pictures["indirect"], 1.0)
    known = reference(view, "all_indirect").pictures
    return shown(view, known["direct"] + known["indirect"])


def shown(view: View, radiance: np.ndarray, stops: float = 0.0) -> np.ndarray:
    return pixels(signal(radiance, (comparison.studio(view).scene.exposure or 0.0) - stops, "neutral"))


def pixels(values: np.ndarray) -> np.ndarray:
    """uint8 (height, width, 3) of values in [0, 1]."""
    return (255.0 * np.clip(values, 0.0, 1.0) + 0.5).astype(np.uint8)


def grey(values: np.ndarray) -> np.ndarray:
    """uint8 (height, width, 3) of shares (height, width), encoded as sRGB."""
    return pixels(srgb_encode(np.repeat(values[..., None], 3, axis=2)))


def visibility(view: View, words: str) -> np.ndarray:
    """uint8: what the cones see of the sky."""
    one = choice(f"{TECHNIQUE},{words}")
    size = reference(view).size
    made = Renderer(scene_of(view), one.technique, settings=one.settings, size=size, device=device())
    picture = made.render(view.camera)
    assert isinstance(made.technique, VoxelCones)
    found = device().read_texture(made.technique.diffuse.visibility, np.float32, 1)[..., 0]
    return grey(np.where(picture.mask, found, 1.0))


def true_visibility(view: View) -> np.ndarray:
    """The same by paths: surfaces of one albedo below a sky of radiance 1, over that albedo."""
    lit = replace(untextured(scene_of(view)), lights=[], environment=Environment((1.0, 1.0, 1.0)), medium=None)
    picture = traced(lit, view.camera, reference(view).size, "direct")
    return grey(np.where(picture.mask, picture.radiance[..., 0] / ALBEDO, 1.0))


def traced(scene: Scene, camera: str | Camera, size: tuple[int, int], paths: str) -> Any:
    settings = {"samples": PATHS, "paths": paths, "materials": "diffuse", "pixel": "centre"}
    return Renderer(scene, "path-tracer", settings=settings, size=size, device=device()).render(camera)


def each(names: Sequence[str], row: Callable[[View], list[np.ndarray]]) -> np.ndarray:
    return np.concatenate([np.concatenate(row(VIEWS[name]), axis=1) for name in names])


def table_16() -> np.ndarray:
    def row(view: View) -> list[np.ndarray]:
        direct = shown(view, comparison._direct(view)[0].pictures["direct"])
        return [direct, light(view, "depth=8", whole=True), truth(view, whole=True), visibility(view, "depth=8")]

    return each(LIT, row)


def table_17() -> np.ndarray:
    kinds = [f"representation={kind}" for kind in ("axial", "lobes")]
    return each(LIT, lambda view: [*(light(view, kind, whole=False) for kind in kinds), truth(view, whole=False)])


def table_18() -> np.ndarray:
    words = [f"depth={depth}" for depth in DEPTHS]
    return each(LIT, lambda view: [*(light(view, each, whole=True) for each in words), truth(view, whole=True)])


def table_19() -> np.ndarray:
    words = [f"cones={count},width=1.0,samples=3" for count in CONES]
    return each(LIT, lambda view: [*(light(view, each, whole=False) for each in words), truth(view, whole=False)])


def table_20() -> np.ndarray:
    words = [f"depth={depth}" for depth in DEPTHS]
    return each(OPEN, lambda view: [*(visibility(view, each) for each in words), true_visibility(view)])


def figure_1() -> np.ndarray:
    scene = scenes_on_disk.load("crytek_sponza").at(0.0)
    kinds = []
    for kind in ("lobes", "axial"):
        one = choice(f"{TECHNIQUE},bounces=1,representation={kind}")
        made = Renderer(scene, one.technique, settings=one.settings, size=SIZE, device=device())
        kinds.append((made, made.render(CURTAIN)))
    voxels = pixels(kinds[0][0].technique.debug_views()["voxels:0:light"])
    lit = [picture.layers["indirect"] - picture.layers["specular"] for _, picture in kinds]
    lit.append(traced(scene, CURTAIN, SIZE, "first-bounce").radiance)
    exposure = scene.exposure or 0.0
    return np.concatenate([voxels, *(pixels(signal(each, exposure - 2.0, "neutral")) for each in lit)], axis=1)


FIGURES = {
    "16": table_16, "17": table_17, "18": table_18, "19": table_19, "20": table_20, "1": figure_1,
}  # fmt: skip

if __name__ == "__main__":
    sys.exit(save(FIGURES, "vct-6-", "6."))
