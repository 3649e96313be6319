"""Debug views of `voxel-cones`: what the octree holds, as numbers and as the camera sees it (VCT 5.2, figures 5.4
and 5.5, appendix C)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from ....frame.frame import Frame
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.voxels.surfaces import DIRECTIONS
from ...debug_views import DebugViews, Pixel
from .contents import keys_of, level_nodes, level_voxels, merged
from .drawing import Drawing, nearest, picture, surface_cells
from .fragment_list import FragmentList
from .pixel_cones import PixelCones, cone_colour, drawn_over

if TYPE_CHECKING:
    from ..technique import VoxelCones

WAYS = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Names of simulator/voxels/surfaces.DIRECTIONS."""
_SURFACES = ("albedo", "emission")  # which only voxels of level 0 have
_VALUES = ("normal", "opacity", *(f"opacity{way}" for way in WAYS), "light", *(f"light{way}" for way in WAYS))
_UPDATED, _KEPT = (1.0, 0.4, 0.05), (0.15, 0.2, 0.3)


class VoxelViews:
    """Of the last frame of a technique; `all` names them."""

    def __init__(self, technique: VoxelCones):
        self._technique = technique

    def all(self) -> DebugViews:
        """`voxels:LEVEL`, `nodes`, `fragments`, `updates` and `cones` are numbers, all others pictures."""
        makers: dict[str, Callable[[], Any]] = {}
        levels = range(self._technique.octree.depth)
        lobes = ("comes_from",) if self._technique.octree.bricks.representation.directed else ()
        for level in levels:
            makers[f"voxels:{level}"] = partial(self.voxels, level)
        for level in levels:
            for value in (*(_SURFACES if level == 0 else ()), *_VALUES, *lobes):
                makers[f"voxels:{level}:{value}"] = partial(self.drawn_voxels, level, value)
        makers |= {"fragments": self.fragments, "fragments:drawn": self.drawn_fragments, "nodes": self.nodes}
        makers |= {f"nodes:{level}": partial(self.drawn_nodes, level) for level in levels}
        makers["updates"] = self.updates
        makers |= {f"updates:{level}": partial(self.drawn_updates, level) for level in levels}
        makers["visibility"] = self.visibility
        numbers = {"fragments", "nodes", "updates", *(f"voxels:{level}" for level in levels)}
        pictures = {"cones:drawn", *makers} - numbers
        return DebugViews(makers, {"cones": self.cones, "cones:drawn": self.drawn_cones}, pictures)

    @property
    def _frame(self) -> Frame:
        frame = self._technique.frame
        if frame is None:
            raise OctoluxError("There is nothing to look at before a frame has been rendered.")
        return frame

    def voxels(self, level: int) -> np.ndarray:
        """contents.VOXEL_VALUES of the level's voxels in which something faces any way, static or moving."""
        _ = self._frame
        unit = self._technique.injection.unit
        static, *moving = (level_voxels(octree, level, unit) for octree in self._technique.parts.octrees)
        found = merged(static, *moving) if moving else static
        return found[found["facing"].any(axis=1)]

    def drawn_voxels(self, level: int, value: str) -> np.ndarray:
        """The level's voxels as the camera sees them. Light and emission are exposed as the picture is."""
        found = self.voxels(level)
        shown = self._normals(level, found) if value == "normal" else self._shown(found, value)
        return self._draw(level, found["cell"], shown)

    def _normals(self, level: int, found: np.ndarray) -> np.ndarray:
        """Colours (m, 3) of mean normals, of what looks at the camera: those of both sides of a wall add up to none."""
        view, grid = self._frame.views[0], self._technique.octree.grid
        middle = np.asarray(grid.origin) + grid.cell_size * 2.0**level * (found["cell"] + 0.5)
        towards = view.position - middle if view.perspective else np.broadcast_to(-view.forward, middle.shape)
        mean = (found["facing"] * (towards @ DIRECTIONS.T > 0.0)) @ DIRECTIONS
        return 0.5 + 0.5 * mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-9)

    def _shown(self, found: np.ndarray, value: str) -> np.ndarray:
        """Colours (m, 3)."""
        facing, exposure = found["facing"], self._frame.exposure_factor
        if value in _SURFACES:
            return found[value] * (exposure if value == "emission" else 1.0)
        if value == "comes_from":  # grey from everywhere
            return 0.5 + 0.5 * found["comes_from"]
        if value == "opacity":  # across each axis, of the way that faces more
            return np.maximum(facing[:, 0::2], facing[:, 1::2])
        if value == "light":  # of all ways, for what faces them
            return exposure * found["light"].sum(axis=1) / np.maximum(facing.sum(axis=1), 1e-9)[:, None]
        way = WAYS.index(value[-2:])
        if value.startswith("opacity"):
            return np.repeat(facing[:, way, None], 3, axis=1)
        return exposure * found["light"][:, way]

    def _draw(self, level: int, cells: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Of voxels (m, 3) of a level their values (m, 3)."""
        frame, device = self._frame, self._technique.device
        met = [Drawing(device, octree, level).met(frame) for octree in self._technique.parts.octrees]
        return picture(nearest(met), cells, np.clip(values, 0.0, 1.0))

    def fragments(self) -> np.ndarray:
        """fragment_list.FRAGMENT of all that is drawn."""
        octree, scene = self._technique.octree, self._frame.gpu_scene
        return FragmentList(self._technique.device, octree.octree).list(scene, octree)

    def drawn_fragments(self) -> np.ndarray:
        """How many fragments lie in each voxel of level 0: darkest for one, and twice as many a step brighter."""
        n = self._technique.octree.grid.n
        counts = np.zeros((n, n, n), np.int64)
        np.add.at(counts, tuple(self.fragments()["voxel"].T), 1)
        steps = np.log2(2.0 * np.maximum(counts, 1))
        cells = self.voxels(0)["cell"]
        shown = (steps / steps.max())[tuple(cells.T)]
        return self._draw(0, cells, np.repeat(shown[:, None], 3, axis=1))

    def nodes(self) -> np.ndarray:
        """int32 (m, 4), of all nodes: level, and the cell x, y, z of 2^3 of its voxels; the coarsest first."""
        _ = self._frame
        return _rows([level_nodes(octree) for octree in self._technique.parts.octrees])

    def updates(self) -> np.ndarray:
        """The rows of `nodes` whose bricks the last frame made anew (VCT 5.5: the update list)."""
        _ = self._frame
        return _rows([level_nodes(one)[one.filtering.updated_nodes()] for one in self._technique.parts.octrees])

    def drawn_nodes(self, level: int) -> np.ndarray:
        """Surfaces, of each node in another colour."""
        cells = _of_level(self.nodes(), level)
        return self._on_surfaces(level, cells, np.array([cone_colour(i) for i in range(len(cells))]).reshape(-1, 3))

    def drawn_updates(self, level: int) -> np.ndarray:
        """Surfaces are orange where the level's nodes were made anew."""
        cells, updated = (_of_level(rows, level) for rows in (self.nodes(), self.updates()))
        values = np.where(np.isin(keys_of(cells), keys_of(updated))[:, None], _UPDATED, _KEPT)
        return self._on_surfaces(level, cells, values)

    def _on_surfaces(self, level: int, cells: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Values (m, 3) of a level's nodes, of cells (m, 3), on what is seen (VCT C.2: voxel-fragment colour mode)."""
        grid = self._technique.octree.grid
        of_nodes = Grid(grid.origin, grid.cell_size * 2.0 ** (level + 1), grid.n >> (level + 1))
        return picture(surface_cells(self._technique.device, self._frame, of_nodes), cells, values)

    def visibility(self) -> np.ndarray:
        """Ambient visibility: the share of each pixel's diffuse cones that meets nothing."""
        _ = self._frame
        read = self._technique.device.read_texture(self._technique.diffuse.visibility, np.float32, 1)
        return np.repeat(read, 3, axis=2)

    def cones(self, pixel: Pixel) -> np.ndarray:
        """pixel_cones.CONE_SAMPLE of the pixel's cones, the diffuse ones and then, where surfaces are `glossy`, the
        specular one."""
        technique, frame = self._technique, self._frame
        s = technique.settings
        traced = PixelCones(
            technique.device, technique.voxels, technique.wide, step=s.step, resolution=technique.diffuse.resolution,
            offset=s.offset, cover=s.cover, glossy=s.glossy, attenuation=s.attenuation,
        )  # fmt: skip
        at = pixel or (frame.pixels[0] // 2, frame.pixels[1] // 2)
        return traced.samples(frame, technique.octree.grid, at, **technique.reading.resources)

    def drawn_cones(self, pixel: Pixel) -> np.ndarray:
        """The picture, and on it the samples."""
        frame, samples = self._frame, self.cones(pixel)
        radiance = self._technique.device.read_texture(frame.targets.radiance, np.float32, 4)[..., :3]
        exposed = np.clip(radiance * np.float32(frame.exposure_factor), 0.0, 1.0)
        return drawn_over(exposed, samples, frame.views[0], self._technique.octree.grid, frame.exposure_factor)


def _rows(parts: list[np.ndarray]) -> np.ndarray:
    """Each row of (m, 4) once, the highest levels first."""
    rows = np.unique(np.concatenate(parts), axis=0)
    return rows[np.argsort(-rows[:, 0], kind="stable")]


def _of_level(rows: np.ndarray, level: int) -> np.ndarray:
    return rows[rows[:, 0] == level, 1:]
