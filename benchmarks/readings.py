"""From intensity to irradiance: the two cases known exactly, and two plates."""

from __future__ import annotations

from math import pi

import numpy as np

from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.meshes import Mesh
from octolux.simulator import sh
from octolux.simulator.form_factors import irradiance_from_parallel_square
from octolux.simulator.grid import Grid
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings

from .given_light import seen_in
from .registry import figure, within

N, CELL = 32, 0.25
VOLUME = Grid((-4.0, -4.0, -4.0), CELL, N)
FLUX = 2.0
# The volumes are half floats: a coefficient errs by 2^-11 rounded, by 2^-10 where an adapter truncates.
HALF_FLOAT = 1e-3


def facing_plate(z: float, half_side: float = 1.0) -> Mesh:
    """A square in the plane `z` that faces -z."""
    s = half_side
    return quad([(s, -s, z), (-s, -s, z), (-s, s, z), (s, s, z)])


def middle_irradiance(light: np.ndarray, preset: str, iterations: int, z: float) -> float:
    """Irradiance, lx, in the middle of a plate at `z` that faces -z, as the preset reads `light` after the steps."""
    settings = UniformLpvSettings.from_strings(preset, {"n": str(N), "iterations": str(iterations)})
    camera = Camera.look_at((0.0, 0.0, z - 3.0), (0.0, 0.0, z))
    picture = seen_in(facing_plate(z), camera, (3, 3), settings, light, VOLUME)
    return float(picture.layers["irradiance"][1, 1].mean())


def everywhere(coefficients: np.ndarray) -> np.ndarray:
    """The same light in all cells."""
    return np.broadcast_to(coefficients, (N, N, N, 3, 4)).astype(np.float32)


def beam(preset: str) -> float:
    """Reading of flux F along +z through every cell, over F / h^2."""
    light = everywhere(FLUX / pi * sh.cosine_lobe([0.0, 0.0, 1.0]))
    return middle_irradiance(light, preset, 0, 0.1) / (FLUX / CELL**2)


def furnace(preset: str) -> float:
    """Reading of isotropic flux F in every cell, of which each of the six faces gets a sixth, over F / (6 h^2)."""
    light = everywhere(FLUX * np.array([sh.Y0, 0.0, 0.0, 0.0]))  # F / (4 pi) = Y0 c00
    return middle_irradiance(light, preset, 0, 0.1) / (FLUX / (6.0 * CELL**2))


@figure("reading", group="closed_form", unit="x", bound={
    "default_beam": within(1.0, HALF_FLOAT), "default_furnace": within(1.0, HALF_FLOAT),
    "paper_beam": within(3 / pi, HALF_FLOAT), "paper_furnace": within(6 / pi, 6 / pi * HALF_FLOAT),
})  # fmt: skip
def reading() -> dict[str, float]:
    """Irradiance read of a beam and of a furnace over the exact one (simulator/lpv/lookup.py), by the device."""
    return {f"{p}_{case.__name__}": case(p) for p in ("default", "paper") for case in (beam, furnace)}


PLATE_CELLS, PLATE_Z = 8, 10


def lit_plate() -> np.ndarray:
    """Light just injected by a plate of 8 x 8 cells in the middle of plane z = 10 cells that faces +z, FLUX a cell."""
    light = np.zeros((N, N, N, 3, 4), np.float32)
    first = (N - PLATE_CELLS) // 2
    cells = slice(first, first + PLATE_CELLS)
    light[PLATE_Z, cells, cells] = FLUX / pi * sh.cosine_lobe([0.0, 0.0, 1.0])
    return light


@figure("plates", group="closed_form", unit="x")
def plates() -> dict[str, float]:
    """Irradiance in the middle of a plate that faces a lit one of 8 x 8 cells, over the analytic form factor's."""
    light, result = lit_plate(), {}
    radiance = FLUX / CELL**2 / pi
    for preset in ("default", "paper"):
        for apart in (2, 4, 8):
            exact = float(irradiance_from_parallel_square(radiance, PLATE_CELLS * CELL, apart * CELL))
            z = VOLUME.origin[2] + (PLATE_Z + apart) * CELL
            for steps in (8, 16, 32):
                found = middle_irradiance(light, preset, steps, z)
                result[f"{preset}_{apart}_cells_k{steps}"] = found / exact
    return result
