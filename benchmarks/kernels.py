"""Injection, propagation and lookup on the device against their float64 versions, on random input."""

from __future__ import annotations

import numpy as np

from octolux.frame.structs import VPL
from octolux.gpu.records import record_texture
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import injection as injection_reference
from octolux.simulator.lpv import lookup as lookup_reference
from octolux.simulator.lpv import propagation as propagation_reference
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.injection import Injection, VplSource
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings

from .given_light import seen_in
from .lab import device, random_directions, read_buffer, submitted
from .propagation import preset_propagation, propagated, random_light
from .registry import at_most, figure

N = 16
GRID = Grid((-1.0, -0.5, 2.0), 0.25, N)
F32, F16 = at_most(1e-4), at_most(2e-3)
PRESETS = ("default", "paper", "thesis")


def cell_error(found: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of SH arrays (..., rgb, 4) relative to the cell's largest coefficient; infinite where a cell
    should be dark and is not."""
    peak = np.abs(expected).max(axis=(-2, -1))
    difference = np.abs(found - expected).max(axis=(-2, -1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.where(difference == 0.0, 0.0, difference / peak).max())


def random_vpls(rng: np.random.Generator, count: int, total: float) -> np.ndarray:
    """VPLs in and around the grid whose flux adds to at most `total`, lm. After the move by half a cell none lies
    within a hundredth of a cell of a face, where float32 and float64 may choose different cells."""
    vpls = VPL.array(count)
    vpls["normal"] = pack_normals(random_directions(rng, count))
    cells = rng.integers(-1, N + 1, (count, 3)) + rng.uniform(0.01, 0.99, (count, 3))
    moved = np.array(GRID.origin) + GRID.cell_size * cells
    vpls["position"] = moved - 0.5 * GRID.cell_size * unpack_normals(vpls["normal"])
    vpls["flux"] = rng.uniform(0.1, 1.0, (count, 3)) * total / count
    return vpls


@figure("kernel_injection", group="kernels", unit="relative", bound=F32)
def kernel_injection() -> float:
    """Two lights of 5000 VPLs, one a million times the other's flux: largest difference over the cell's largest."""
    rng = np.random.default_rng(1)
    lights = [random_vpls(rng, 5000, total) for total in (1.0, 1e6)]
    sources = [VplSource(i * 5000, 5000, np.full(3, total)) for i, total in enumerate((1.0, 1e6))]
    packed = VPL.array(10000)
    packed[:5000], packed[5000:] = lights
    made, grid = Injection(device(), N), device().uniform("grid", pack_grid(GRID))
    with submitted() as stage:
        made.run(stage, grid, record_texture(device(), "VPLs", VPL, len(packed), packed), sources)
    found = read_buffer(made.injected).reshape(N, N, N, 3, 4)
    parts = [
        injection_reference.inject(v["position"], unpack_normals(v["normal"]), v["flux"], GRID) for v in lights
    ]
    return cell_error(found, sum(parts))


@figure("kernel_propagation", group="kernels", unit="relative",
        bound={f"{p}_{f}": b for p in PRESETS for f, b in (("f32", F32), ("f16", F16))})  # fmt: skip
def kernel_propagation() -> dict[str, float]:
    """8 steps of every preset in 16^3 random cells, in both cell formats."""
    light, result = random_light(N, seed=2), {}
    for preset in PRESETS:
        s = UniformLpvSettings.from_strings(preset)
        expected = propagation_reference.propagate(light, 8, s.gain, s.evaluation, s.reprojection)
        for cells in ("f32", "f16"):
            found = propagated(preset_propagation(preset, N, cells), light, 8)
            result[f"{preset}_{cells}"] = cell_error(found, expected)
    return result


def smooth_light() -> np.ndarray:
    """Float32 light in 16^3 cells that varies by some percent from cell to cell: texture units may round the weights of
    a filtered sample to 1/256, which must not be what the figure shows."""
    rng, centre = np.random.default_rng(3), GRID.cell_centres()
    light = np.empty((N, N, N, 3, 4), np.float32)
    for channel in range(3):
        light[..., channel, 0] = 2.0 + np.sin(0.7 * centre @ random_directions(rng, 1)[0])
        turned = np.stack([np.cos(0.7 * centre @ d + d[0]) for d in random_directions(rng, 3)], axis=-1)
        light[..., channel, 1:] = turned * light[..., channel, :1] * rng.uniform(0.1, 0.6)
    return light


@figure("kernel_lookup", group="kernels", unit="relative", bound=F16)
def kernel_lookup() -> dict[str, float]:
    """Every reading of half-float volumes on the walls of a box: difference over the most irradiance possible there,
    that on a surface which faces the light at that point."""
    light, result = smooth_light(), {}
    middle = np.array(GRID.origin) + 0.5 * N * GRID.cell_size
    room = box(middle - 1.6, middle + 1.6, inward=True)
    for reading in lookup_reference.READINGS:
        settings = UniformLpvSettings.from_strings(overrides={"n": str(N), "iterations": "0", "reading": reading})
        worst = 0.0
        for towards in ((1.0, 0.4, 0.3), (-0.6, 0.5, -1.0), (0.2, -1.0, 0.1)):
            camera = Camera.look_at(middle, middle + towards, vertical_fov=1.4)
            picture = seen_in(room, camera, (64, 64), settings, light, GRID)
            worst = max(worst, _lookup_error(picture, light, settings))
        result[reading] = worst
    return result


def _lookup_error(picture, light: np.ndarray, settings: UniformLpvSettings) -> float:
    layers = picture.layers
    places = layers["position"] + settings.lookup_offset * GRID.cell_size * picture.geometric_normal
    sampled = lookup_reference.sample_trilinear(light, GRID, places)
    band1 = sampled[..., [3, 1, 2]]
    facing = -band1 / np.linalg.norm(band1, axis=-1, keepdims=True)
    read = settings.reading
    expected = lookup_reference.irradiance(sampled, layers["normal"], GRID.cell_size, read, settings.scale)
    most = np.stack([
        lookup_reference.irradiance(sampled, facing[..., c, :], GRID.cell_size, read, settings.scale)[..., c]
        for c in range(3)
    ], axis=-1)  # fmt: skip
    return float((np.abs(layers["irradiance"] - expected) / most)[picture.mask].max())
