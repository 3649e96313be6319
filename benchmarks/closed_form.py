"""Spherical harmonics and propagation in closed form: what a step must do to flux."""

from __future__ import annotations

from math import pi

import numpy as np

from octolux.simulator import sh
from octolux.simulator.lpv import propagation as reference

from .lab import random_directions
from .propagation import preset_propagation, propagated, random_light
from .registry import at_least, at_most, figure, within

# Light in the middle of 16^3 cells meets the border in the eighth step.
N, MIDDLE, STEPS = 16, 8, 7
# What clamping adds to a cosine lobe's first step, by its direction (simulator/lpv/propagation.py, "clamped").
CLAMPED_GAIN = (0.114, 0.141)


def _random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A rotation matrix (3, 3)."""
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


@figure("sh_projection", group="closed_form", unit="relative", bound=at_most(1e-6))
def sh_projection() -> float:
    """Projecting a function of two bands returns its coefficients: largest error over the largest coefficient."""
    coefficients = np.random.default_rng(1).normal(size=(20, 4))
    errors = [np.abs(sh.project(lambda w, c=c: sh.evaluate(c, w)) - c).max() / np.abs(c).max() for c in coefficients]
    return float(max(errors))


@figure("sh_cosine_lobe", group="closed_form", unit="relative", bound=at_most(1e-6))
def sh_cosine_lobe() -> float:
    """The clamped cosine's closed form (OLPV eq. 7) against its projection by quadrature, along and off the axis.

    Off the axis the quadrature meets the cosine's kink, so those are turned from the axis by `sh.rotate`.
    """
    rng = np.random.default_rng(2)
    upright = sh.project(lambda w: np.maximum(0.0, w[:, 2]))
    errors = []
    for _ in range(20):
        turn = _random_rotation(rng)
        errors.append(np.abs(sh.rotate(upright, turn) - sh.cosine_lobe(turn[:, 2])).max())
    return float(max(errors) / sh.COSINE_LOBE_1)


@figure("sh_rotation", group="closed_form", unit="relative", bound=at_most(1e-6))
def sh_rotation() -> float:
    """A rotated function at a rotated direction is the function: largest error over the largest coefficient."""
    rng = np.random.default_rng(3)
    coefficients, directions = rng.normal(size=(50, 4)), random_directions(rng, 50)
    turn = _random_rotation(rng)
    turned = sh.evaluate(sh.rotate(coefficients, turn), directions @ turn.T)
    return float(np.abs(turned - sh.evaluate(coefficients, directions)).max() / np.abs(coefficients).max())


def step_gain(preset: str) -> float:
    """Flux after a step on the device over flux before. The intensity is nowhere negative, so that clamping changes
    nothing and the gain is that of the signed evaluation (simulator/lpv/propagation.py)."""
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[6:10, 6:10, 6:10] = random_light(4, directed=1 / np.sqrt(3))
    made = preset_propagation(preset, N)
    after = propagated(made, light, 1) - propagated(made, light, 0)
    return float(reference.total_flux(after).sum() / reference.total_flux(light.astype(np.float64)).sum())


@figure("step_gain", group="closed_form", unit="x",
        bound={"default": within(1.0, 1e-3), "paper": within(1.0, 1e-3), "thesis": within(0.75, 1e-3)})  # fmt: skip
def step_gain_of_presets() -> dict[str, float]:
    """Flux after a step over flux before, of every preset with its own cells, on the device."""
    return {preset: step_gain(preset) for preset in ("default", "paper", "thesis")}


def _lobes() -> np.ndarray:
    """Cosine lobes of flux 1 along axes, diagonals and at random: (4, 3, 4), three to a volume, one a channel."""
    rng = np.random.default_rng(4)
    axes = np.array([[1.0, 0, 0], [0, -1, 0], [1, 1, 0], [1, 1, 1], [-1, 2, 0], [0, 1, -3]])
    directions = np.concatenate([axes / np.linalg.norm(axes, axis=1, keepdims=True), random_directions(rng, 6)])
    return (sh.cosine_lobe(directions) / pi).reshape(4, 3, 4)


def flux_by_step(preset: str, cell_format: str, evaluation: str = "") -> np.ndarray:
    """Flux in the volume after 0 to STEPS steps of each of the lobes, on the device: (STEPS + 1, 12)."""
    made = preset_propagation(preset, N, cell_format, evaluation)
    columns = []
    for lobes in _lobes():
        light = np.zeros((N, N, N, 3, 4), np.float32)
        light[MIDDLE, MIDDLE, MIDDLE] = lobes
        sums = np.stack([reference.total_flux(propagated(made, light, k)) for k in range(STEPS + 1)])
        columns.append(np.diff(sums, axis=0, prepend=0.0))
    return np.concatenate(columns, axis=1)


def _drift(flux: np.ndarray) -> float:
    """Largest relative change from the first row."""
    return float(np.abs(flux / flux[0] - 1.0).max())


@figure("flux_kept", group="closed_form", unit="relative", bound={
    **dict.fromkeys(("signed_f32", "signed_f16", "dominant_lobe_f32", "dominant_lobe_f16"), at_most(1e-3)),
    "clamped_first_least": at_least(CLAMPED_GAIN[0]), "clamped_first_most": at_most(CLAMPED_GAIN[1]),
    "clamped_later": at_most(5e-3),
})  # fmt: skip
def flux_kept() -> dict[str, float]:
    """Largest change of flux in 7 steps from the middle of 16^3 cells; clamped: gain of the first, change after it."""
    result = {}
    for cells in ("f32", "f16"):
        result[f"signed_{cells}"] = _drift(flux_by_step("paper", cells, "signed"))
        result[f"dominant_lobe_{cells}"] = _drift(flux_by_step("default", cells))
    clamped = flux_by_step("paper", "f16")
    first = clamped[1] / clamped[0] - 1.0
    return {
        **result, "clamped_first_least": float(first.min()), "clamped_first_most": float(first.max()),
        "clamped_later": _drift(clamped[1:]),
    }  # fmt: skip
