"""Numbers as the device stores them while light travels: what faces let through and reflect, and cells of a few bytes.

Thousandths. Three numbers of [0, 1] lie in the 10-bit fields of a word, in steps of 1/1023, rounded to the nearest: 0
and 1 stay what they are, others move by at most half a step, 4.9e-4. A step with the stored numbers creates no light:
what a face blocks is one less what it lets through, both of the same stored number (bounces.py). So that the part of
surfaces across the face is in what light from the side is stored to lose, that may be rounded by 1.2 steps.

Byte cells ("snorm8"). A channel of a cell is one word, half of what half floats take: three numbers of 8 bits, signed
normalised, and one of 8 bits, a size that they are shares of. What is stored is the emission e that a step reads
(techniques/lpv/cells.wgsl), v = e1 to e3:

- "signed" and "clamped", e are the SH coefficients: the size is e0 and the shares v / (2/sqrt(3) e0), no mix of cosine
  lobes being longer (sh.dominant_lobe).
- "dominant_lobe", e0 is the isotropic part and v the lobe: the size is 4 e0 + the largest |v|, which leaves both in
  reach whichever is 0, and the shares are v over it.

Size. 256 sizes from 0 to 64 (storage_scale.wgsl keeps light below that) lie as float32 does, evenly between powers of
two: from 2^-8 on, which is 2^-11 of the peak or less, two are at most 5.5 % apart; down to 0 they lie evenly, 2^-12.2
from one to the next. Rounding to the nearest would hold on to light that changes by less than half of that from step to
step. So a size is rounded up where the share of the gap that it has reached is above a threshold, and thresholds
differ from cell to cell and between two steps, evenly in [0, 1): the mean is kept, whatever the size. The size is
chosen after the shares have been rounded, such that the cell's flux is kept, and not that of the shares before. So
the flux of N cells of equal light is off by 2.7 % / sqrt(N) (a standard deviation is at most half the gap), in each
step anew: after k steps, by sqrt(k) times that.

Coarse levels of an octree whose parents are sums outgrow the largest size: they need f16.
"""

from __future__ import annotations

from math import pi

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.lpv import transfer

STEPS = 1023
"""Steps between 0 and 1 of a 10-bit field."""

OCTAVES = 14
"""Powers of two that sizes of 8 bits span, the last of them up to 64."""

GAP = OCTAVES / 255
"""Between neighbouring sizes, relative to the power of two below them."""

FIRST = int(np.float32(2.0 ** (6 - OCTAVES)).view(np.int32))
STEP = (OCTAVES << 23) // 255
LEAST = 2.0 ** (6 - OCTAVES)
BYTE_CELLS = {"byte_first": FIRST, "byte_step": STEP, "byte_least": LEAST}
"""Size number c is the float32 with the bits FIRST + STEP c, less LEAST."""

_LONGEST = harmonics.COSINE_LOBE_1 / harmonics.COSINE_LOBE_0


def pack_thousandths(x) -> np.ndarray:
    """Numbers (..., 3) from 0 to 1 as words: uint32 (...)."""
    steps = np.round(np.asarray(x, dtype=np.float64) * STEPS).astype(np.uint32)
    return steps[..., 0] | (steps[..., 1] << 10) | (steps[..., 2] << 20)


def unpack_thousandths(words) -> np.ndarray:
    """The numbers of words (...): float64 (..., 3)."""
    words = np.asarray(words, dtype=np.uint32)[..., None]
    return ((words >> np.array([0, 10, 20], np.uint32)) & STEPS) / float(STEPS)


def lobe_flux(v) -> np.ndarray:
    """Flux (...) of lobes v (..., 3), each component along y, z or x: sum of max(0, v.m) over the 30 faces."""
    by_axis = np.asarray(v, dtype=np.float64)[..., [2, 0, 1]]
    return np.maximum(0.0, by_axis @ transfer.MOMENTS.reshape(30, 3).T).sum(axis=-1)


def sizes(codes) -> np.ndarray:
    """Sizes that codes 0 to 255 (...) stand for, float64."""
    bits = FIRST + STEP * np.asarray(codes, dtype=np.int32)
    return bits.astype(np.int32).view(np.float32).astype(np.float64) - LEAST


def thresholds(index, dither: float) -> np.ndarray:
    """Where along its gap a size at storage index (...) is rounded up, in [0, 1). dither: 0 or 0.5, by the step."""
    multiplied = np.asarray(index, dtype=np.uint64) * 0x9E3779B9 & 0xFFFFFFFF  # 2^32 over the golden ratio
    return ((multiplied >> 8) / 2.0**24 + dither) % 1.0


def pack_cells(e, index, dither: float, evaluation: str) -> np.ndarray:
    """Emissions (..., 4), e0 at least 0, scaled for storage, as words: uint32 (...)."""
    e = np.asarray(e, dtype=np.float64)
    dominant = evaluation == "dominant_lobe"
    size = 4.0 * e[..., 0] + np.abs(e[..., 1:]).max(axis=-1) if dominant else e[..., 0] * _LONGEST
    shares = np.clip(np.round(e[..., 1:] / np.maximum(size, 1e-30)[..., None] * 127.0), -127, 127)
    if dominant:
        kept = _unit_flux(shares / 127.0)
        size = (4.0 * pi * e[..., 0] + lobe_flux(e[..., 1:])) / kept
    else:
        size = e[..., 0]
    table = sizes(np.arange(256))
    code = np.clip(np.searchsorted(table, size, side="right") - 1, 0, 254)
    code += size - table[code] > thresholds(index, dither) * (table[code + 1] - table[code])
    fields = shares.astype(np.int32).astype(np.uint32) & 255
    return fields[..., 0] | fields[..., 1] << 8 | fields[..., 2] << 16 | code.astype(np.uint32) << 24


def _unit_flux(shares: np.ndarray) -> np.ndarray:
    """Flux of a cell of size 1."""
    return pi * (1.0 - np.abs(shares).max(axis=-1)) + lobe_flux(shares)


def unpack_cells(words, evaluation: str) -> np.ndarray:
    """The emissions of words (...): float64 (..., 4)."""
    words = np.asarray(words, dtype=np.uint32)
    size = sizes(words >> 24)
    shares = np.stack([(words >> k & 255).astype(np.uint8).view(np.int8) / 127.0 for k in (0, 8, 16)], axis=-1)
    if evaluation == "dominant_lobe":
        constant = 0.25 * (1.0 - np.abs(shares).max(axis=-1))
        return size[..., None] * np.concatenate([constant[..., None], shares], axis=-1)
    return size[..., None] * np.concatenate([np.ones_like(size)[..., None], _LONGEST * shares], axis=-1)
