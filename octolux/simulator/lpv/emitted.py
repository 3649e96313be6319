"""Low-frequency direct light, injected as VPLs (Kaplanyan & Dachsbacher 2010, 3.1).

A large group of point lights, glowing surfaces and the surroundings become many records, each of which sends a flux
Phi on. A share `beam` of it leaves as a cosine lobe around `axis`, the rest alike in all directions:

    I(w) = Phi * (beam * max(0, w.axis) / pi + (1 - beam) / (4 pi))

so that its coefficients are Phi / pi * (sqrt(pi) / 2, beam * sqrt(pi / 3) * axis). A point has a beam of 0, a flat
patch of 1. Light of the surroundings that enters through a face of a cell may be narrower than a cosine lobe: its beam
is what makes band 1 right, at most 1.5 (parallel light: Y1 Phi), and readers clamp it.

Each record is moved half a cell along beam * axis, as other VPLs are along their normal: a patch lies on a surface
that it must not light, a point does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from octolux.scene.environment import Environment
from octolux.scene.particles import ParticleLights
from octolux.simulator import sh as harmonics
from octolux.simulator.environment import radiance, reduced, texel_directions, texel_solid_angles
from octolux.simulator.grid import Grid

from .transfer import DIRECTIONS

MOST_BEAM = 1.5
"""Of parallel light: band 1 over that of a cosine lobe, Y1 / (sqrt(pi / 3) / pi)."""

MOST_PATCHES = 1 << 16
"""Patches are not cut further when there would be more of them."""

_TEXELS = 256
"""Width of the map that the surroundings' light is summed over: a texel is 1.4 degrees."""

_INSIDE = 1e-3
"""Cells from a grid's sides that a record of its surroundings stands at least: rounding does not take it out."""

_SAME_LOBE = 1e-4
"""Channels whose beams differ by no more share a record: as exact as a packed axis (camera.py, `pack_normals`)."""


@dataclass(frozen=True, eq=False)
class Emitted:
    """position: (M, 3), world space, metres.  flux: (M, 3), lm or W.  axis: (M, 3) unit.  beam: (M,)."""

    position: np.ndarray
    flux: np.ndarray
    axis: np.ndarray
    beam: np.ndarray

    @classmethod
    def joined(cls, parts: Sequence[Emitted]) -> Emitted:
        if not parts:
            return cls(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
        arrays = ([getattr(part, name) for part in parts] for name in ("position", "flux", "axis", "beam"))
        return cls(*(np.concatenate(values) for values in arrays))

    @property
    def bound(self) -> np.ndarray:
        """(3,): a flux for which no sum of coefficients exceeds that of cosine lobes along one axis."""
        return (self.flux * np.maximum(1.0, self.beam)[:, None]).sum(axis=0)


def particle_records(groups: Sequence[ParticleLights]) -> Emitted:
    """A record for each particle: 4 pi I, alike in all directions."""
    made = []
    for group in groups:
        count = len(group.positions)
        upward = np.tile([0.0, 0.0, 1.0], (count, 1))
        made.append(Emitted(group.positions, 4.0 * pi * group.intensities, upward, np.zeros(count)))
    return Emitted.joined(made)


def patch_records(corners, radiance, longest: float, most: int = MOST_PATCHES) -> Emitted:
    """Glowing triangles as records, cut until no edge is longer than `longest`, metres, or there are `most`.

    corners: (M, 3, 3), counter-clockwise where they shine to.  radiance: (M, 3), nits. Each record is pi L A at the
    triangle's centroid, facing as it does. Raises ValueError when `longest` is not positive.
    """
    corners, owner = bisected(np.asarray(corners, dtype=np.float64), longest, most)
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)[:, None]
    flux = pi * np.asarray(radiance, dtype=np.float64)[owner] * area
    return Emitted(corners.mean(axis=1), flux, normals / np.maximum(area, 1e-300), np.ones(len(corners)))


def bisected(corners: np.ndarray, longest: float, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (N, 3, 3) that `corners` (M, 3, 3) are cut into, across the middle of their longest edges (Rivara
    1984), and the number of the one that each is part of, (N,)."""
    if not longest > 0.0:
        raise ValueError(f"the longest edge must be positive, got {longest}")
    owner = np.arange(len(corners))
    while True:
        edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
        large = edges.max(axis=1, initial=0.0) > longest
        if not large.any() or len(corners) + np.count_nonzero(large) > most:
            return corners, owner
        first = edges[large].argmax(axis=1)[:, None]
        a, b, c = (np.take_along_axis(corners[large], ((first + k) % 3)[..., None], axis=1)[:, 0] for k in range(3))
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        corners = np.concatenate([corners[~large], *halves])
        owner = np.concatenate([owner[~large], owner[large], owner[large]])


def face_light(environment: Environment) -> tuple[np.ndarray, np.ndarray]:
    """What enters through a face of a box, by the face's outward normal in the order of `transfer.DIRECTIONS`.

    Returns the irradiance E = integral of L(d) max(0, d.n) dd, (6, 3) [face][rgb], lx; and the first moment of what
    then travels on along -d, the integral of L(d) max(0, d.n) (-d) dd, (6, 3, 3) [face][rgb][x, y, z].
    """
    image = None if environment.image is None else reduced(environment.image, _TEXELS)
    height, width = _texels((1, 2) if image is None else image.shape[:2])
    directions = texel_directions(height, width, environment.rotation)
    power = radiance(replace(environment, image=image), directions) * texel_solid_angles(height, width)[..., None]
    directions, power = directions.reshape(-1, 3), power.reshape(-1, 3)
    through = np.maximum(0.0, directions @ DIRECTIONS.T)  # (texels, faces)
    return through.T @ power, np.einsum("tf,tc,tx->fcx", through, power, -directions)


def _texels(shape: tuple[int, ...]) -> tuple[int, int]:
    """Height and width of the map that is summed over: a whole multiple of the surroundings' own, whose texels are read
    bilinearly: only then is all of their light counted."""
    height, width = shape[:2]
    times = max(1, min(_TEXELS // width, _TEXELS // 2 // height))
    return times * height, times * width


def environment_records(environment: Environment, grid: Grid) -> Emitted:
    """What the surroundings send into the grid, through every face of a cell that is part of the grid's border.

    A record's flux is E times the face's area. Injection moves it half a cell along beam * axis, to the middle of the
    cell that the face belongs to: it stands as far behind, but not beyond the grid, where the smaller cells of a grid
    within would not have it. Channels whose light comes from other directions have records of their own.
    """
    irradiance, moment = face_light(environment)
    # A lobe's first moment is 2/3 beam Phi axis (the mean cosine of a cosine lobe).
    beams = 1.5 * moment / np.where(irradiance > 0.0, irradiance, np.inf)[..., None]
    inside = grid.origin + grid.cell_size * np.array([[_INSIDE], [grid.n - _INSIDE]])
    made = []
    for face, cells in enumerate(_border(grid)):
        for channels in _alike(irradiance[face], beams[face]):
            beam = beams[face][channels].mean(axis=0)
            size = min(float(np.linalg.norm(beam)), MOST_BEAM)
            flux = np.where(np.isin(np.arange(3), channels), irradiance[face], 0.0) * grid.cell_size**2
            axis = beam / np.linalg.norm(beam)
            behind = np.clip(cells - 0.5 * grid.cell_size * size * axis, *inside)
            shape = (len(cells), 3)
            made.append(
                Emitted(behind, np.broadcast_to(flux, shape), np.broadcast_to(axis, shape), np.full(len(cells), size))
            )
    return Emitted.joined(made)


def _alike(irradiance: np.ndarray, beams: np.ndarray) -> list[list[int]]:
    """The channels that bring light: together where they have one lobe, else each alone."""
    lit = [channel for channel in range(3) if irradiance[channel] > 0.0]
    if lit and np.ptp(beams[lit], axis=0).max() <= _SAME_LOBE:
        return [lit]
    return [[channel] for channel in lit]


def _border(grid: Grid) -> list[np.ndarray]:
    """Centres (n^2, 3) of the cells along each of the six sides of the grid, in the order of `transfer.DIRECTIONS`."""
    centres = grid.cell_centres()
    sides = [centres.take(-1 if d.sum() > 0 else 0, axis=2 - int(np.abs(d).argmax())) for d in DIRECTIONS]
    return [side.reshape(-1, 3) for side in sides]


def coefficients(emitted: Emitted) -> np.ndarray:
    """SH intensity (M, 3, 4), W/sr (cd)."""
    vector = harmonics.COSINE_LOBE_1 * (emitted.beam[:, None] * emitted.axis)[:, harmonics.VECTOR_TO_BAND1]
    shape = np.concatenate([np.full((len(vector), 1), harmonics.COSINE_LOBE_0), vector], axis=1)
    return emitted.flux[..., None] / pi * shape[:, None, :]


def inject(emitted: Emitted, grids: Sequence[Grid]) -> np.ndarray:
    """Initial light of nested grids of n^3 cells, the finest first: float64 [grid][z][y][x][rgb][4], W/sr (cd).

    A record goes into every grid that holds it after it was moved half a cell of that grid along beam * axis. Those
    that none holds are omitted.
    """
    n, values = grids[0].n, coefficients(emitted)
    light = np.zeros((len(grids), n, n, n, 3, 4))
    for own, held, (x, y, z) in _held(emitted, grids):
        np.add.at(light[own], (z, y, x), values[held])
    return light


def inject_moments(emitted: Emitted, grids: Sequence[Grid]) -> np.ndarray:
    """Where in its cells the light of `inject` comes from, [grid][z][y][x][3], as injection.inject_moments."""
    n, weights = grids[0].n, coefficients(emitted)[..., 0].sum(axis=-1)
    moments = np.zeros((len(grids), n, n, n, 3))
    for own, held, (x, y, z) in _held(emitted, grids):
        beside = grids[own].to_cells(emitted.position[held]) - np.stack([x, y, z], axis=-1) - 0.5
        np.add.at(moments[own], (z, y, x), weights[held, None] * beside)
    return moments


def _held(emitted: Emitted, grids: Sequence[Grid]) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
    """Of each grid: its number, which records it holds (M,), and their cells (3, ...) x, y, z."""
    for number, grid in enumerate(grids):
        cells = grid.cell_of(emitted.position + 0.5 * grid.cell_size * emitted.beam[:, None] * emitted.axis)
        held = np.all((cells >= 0) & (cells < grid.n), axis=1)
        yield number, held, cells[held].T
