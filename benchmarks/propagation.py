"""How fast the propagation is, against a plain gather kernel in the same run."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.simulator.lpv import propagation as reference
from octolux.simulator.lpv import transfer
from octolux.techniques.lpv.propagation import Propagation
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings

from .lab import device, interleaved, random_directions, read_buffer, submitted
from .registry import at_least, at_most, figure

N, STEPS, PAIRS = 32, 8, 61
_GATHER = Path(__file__).parent / "baselines" / "propagation_gather.wgsl"


def random_light(n: int, seed: int = 0, directed: float = 2 / np.sqrt(3)) -> np.ndarray:
    """Float32 [z][y][x][rgb][4], W/sr: band 0 from 0.5 to 2, band 1 up to `directed` of it in random directions; at
    2 / sqrt(3) it is all that a mix of cosine lobes can have, at 1 / sqrt(3) the intensity is nowhere negative."""
    rng = np.random.default_rng(seed)
    light = np.empty((n, n, n, 3, 4), np.float32)
    light[..., 0] = rng.uniform(0.5, 2, (n, n, n, 3))
    length = light[..., :1] * rng.uniform(0, directed, (n, n, n, 3, 1))
    light[..., 1:] = random_directions(rng, n, n, n, 3) * length
    return light


@cache
def preset_propagation(preset: str, n: int, cell_format: str = "", evaluation: str = "") -> Propagation:
    """The propagation of a preset, in its own cell format and evaluation unless others are named."""
    s = UniformLpvSettings.from_strings(preset)
    return Propagation(
        device(), [n], evaluation=evaluation or s.evaluation, reprojection=s.reprojection, gain=s.gain,
        cell_format=cell_format or s.cell_format,
    )  # fmt: skip


def propagated(made: Propagation, light: np.ndarray, iterations: int) -> np.ndarray:
    """S_0 + ... + S_k of `light` on the device: float64 [z][y][x][rgb][4], W/sr."""
    peak = np.array([light[..., 0].max()], np.float32)
    injected, bits = device().buffer("injected", light.astype(np.float32)), device().buffer("peak", peak)
    with submitted() as stage:
        made.run(stage, injected, bits, iterations)
    scale = 2.0 ** (3 - np.floor(np.log2(peak[0])))  # techniques/lpv/storage_scale.wgsl
    return read_buffer(made.light).reshape(light.shape) / np.float64(scale)


def gather_values() -> dict[str, Any]:
    """The baseline's constants: the simulator's, clamped evaluation and face reprojection."""
    lobes = reference.reprojection_lobes("face")
    travels = [
        {
            "direction": transfer.DIRECTIONS[t].tolist(),
            "faces": [
                {"weights": reference.SIGNED_WEIGHTS[t, f].tolist(), "lobe": lobes[t, f].tolist()} for f in range(5)
            ],
        }
        for t in range(6)
    ]
    return {"n": N, "travels": travels}


class Gather:
    """The baseline with its buffers; `run` does the work of Propagation.run after the start."""

    def __init__(self, light: np.ndarray):
        self._pass = ComputePass(
            device(), "gather", str(_GATHER),
            [storage("cells_in", "vec4f"), storage_rw("cells_out", "vec4f", "write"), storage_rw("light", "vec4f")],
            workgroup=(4, 4, 4), **gather_values(),
        )  # fmt: skip
        self.injected = device().buffer("baseline injected", light)
        self._cells = [device().buffer("baseline cells", size=light.nbytes) for _ in range(2)]
        self.light = device().buffer("baseline light", size=light.nbytes)

    def run(self, stage: Any, iterations: int) -> None:
        a, b = self._cells
        for target in (a, self.light):
            stage.encoder.copy_buffer_to_buffer(self.injected, 0, target, 0, self.injected.size)
        forth = {"cells_in": a, "cells_out": b, "light": self.light}
        back = {"cells_in": b, "cells_out": a, "light": self.light}
        self._pass.run_many(stage, (N, N, N), [(forth, back)[i % 2] for i in range(iterations)])


@cache
def _gather() -> Gather:
    return Gather(random_light(N))


def _speedup(preset: str, cell_format: str) -> dict[str, float]:
    """Times and their ratio: recording, submitting and waiting for one command buffer of all steps."""
    made, baseline = preset_propagation(preset, N, cell_format), _gather()
    peak = device().buffer("peak", np.array([2.0], np.float32))

    def plain() -> None:
        with submitted() as stage:
            baseline.run(stage, STEPS)

    def ours() -> None:
        with submitted() as stage:
            made.run(stage, baseline.injected, peak, STEPS)

    times = interleaved(plain, ours, PAIRS)
    return {"ratio": times["ratio"], "gather_ms": times["first"], "octolux_ms": times["second"]}


_UNITS = {"ratio": "x", "gather_ms": "ms", "octolux_ms": "ms"}


@figure("propagation_speedup", group="ratios", unit=_UNITS, bound={"ratio": at_least(1.5)})
def propagation_speedup() -> dict[str, float]:
    """8 steps at 32^3 RGB as the `paper` preset does them, against a plain unrolled gather kernel of the same steps;
    both on cells of 32-bit numbers."""
    return _speedup("paper", "f32")


@figure("propagation_speedup_f16", group="ratios", unit=_UNITS)
def propagation_speedup_f16() -> dict[str, float]:
    """The same with our cells in half floats, as the `paper` preset has them."""
    return _speedup("paper", "f16")


@figure("propagation_speedup_default", group="ratios", unit=_UNITS)
def propagation_speedup_default() -> dict[str, float]:
    """The same for the default preset, whose steps do more than the gather's."""
    return _speedup("default", "")


@figure("propagation_baseline", group="kernels", unit="relative", bound=at_most(1e-4))
def propagation_baseline() -> float:
    """The baseline does the work it is compared for: its largest difference to float64."""
    light = random_light(N)
    with submitted() as stage:
        _gather().run(stage, STEPS)
    found = read_buffer(_gather().light).reshape(light.shape)
    expected = reference.propagate(light, STEPS)
    return float((np.abs(found - expected).max((-1, -2)) / np.abs(expected).max((-1, -2))).max())
