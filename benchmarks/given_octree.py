"""Volumes of light that is given and not injected from lamps: what each cell reads, for every technique with cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.lpv import lookup
from octolux.simulator.lpv.transfer import DIRECTIONS
from octolux.techniques import technique_class
from octolux.techniques.lpv.injection import Injection
from octolux.techniques.lpv.lookup import CHANNELS
from octolux.techniques.technique import Technique

from .lab import device


class _Given(Injection):
    """Writes `light`, [z][y][x][rgb][4], W/sr, in the place of what lamps would bring."""

    light: np.ndarray

    def run(self, stage: Any, grid: Any, vpls: Any, sources: Any) -> None:
        self.device.write(self.injected, self.light)
        self.device.write(self.peak, self.light[..., 0].max(keepdims=True))


def lit_technique(text: str, light: np.ndarray) -> Any:
    """The technique that `text` names, after a frame in the given light with nothing in its way."""
    one = choice(text)
    technique: Any = technique_class(one.technique)(device(), one.settings)
    cells = technique.levels.cells if one.technique == "octree-lpv" else None
    technique.injection = _Given(device(), light.shape[0], cells)
    technique.injection.light = light.astype(np.float32)
    _render(technique)
    return technique


def _render(technique: Technique) -> None:
    """A room without lamps, so that no VPLs and no surfels come in, seen from its middle."""
    technique.needs = frozenset()
    scene = Scene(
        meshes=[box((-1, -1, -1), (1, 1, 1), inward=True)], instances=[Instance(0)], materials=[Material()],
        cameras=[Camera.look_at((0, 0, 0), (1, 0, 0))], exposure=0.0,
    )  # fmt: skip
    renderer = Renderer(scene, "none", size=(16, 16), device=device(), default_light=False)
    renderer.technique = technique
    renderer.render()


def irradiance_of_cells(technique: Any) -> np.ndarray:
    """What is read in the middle of every cell on small faces with the normals DIRECTIONS: float64 [z][y][x][6][rgb],
    in units of the technique's own, the same in all cells."""
    if hasattr(technique, "gathering"):
        cube = read_volume(technique.gathering.cube).astype(np.float64)
        n = technique.settings.n
        return np.moveaxis(cube.reshape(6, n, n, n, 4), 0, 3)[..., :3]
    reader = technique.stepping.lookup if hasattr(technique, "stepping") else technique.lookup
    light = np.stack([read_volume(reader.volumes[c]).astype(np.float64) for c in CHANNELS], axis=3)
    s = technique.settings
    faces = [lookup.irradiance(light, normal, 1.0, s.reading, s.scale) for normal in DIRECTIONS]
    return np.stack(faces, axis=3)


def read_volume(texture: Any) -> np.ndarray:
    """Texels of an rgba16float 3D texture: float16 [z][y][x][4]."""
    width, height, depth = texture.size
    layout = {"bytes_per_row": width * 8, "rows_per_image": height}
    data = device().queue.read_texture({"texture": texture}, layout, texture.size)
    return np.frombuffer(data, np.float16).reshape(depth, height, width, 4)


def border_of_levels(technique: Any, axis: int) -> np.ndarray:
    """Between which neighbours along `axis` (2 is x) the index volume changes level: bool, one less along the axis."""
    flat = np.frombuffer(device().queue.read_buffer(technique.stepping.propagation.touched), np.uint32)
    n, levels = technique.settings.n, technique.levels
    index = np.full((n, n, n), len(levels.sizes) - 1)
    for i in reversed(range(len(levels.sizes) - 1)):
        edge = levels.sizes[i]
        touched = flat[levels.first(i) : levels.first(i) + edge**3].reshape(edge, edge, edge)
        for along in range(3):
            touched = np.repeat(touched, n // edge, axis=along)
        index[touched == 1] = i
    return np.diff(index, axis=axis) != 0
