"""Light of voxels as lobes: one flux, and where it comes from (Drinovsky 2013, "VCT", 2.2.3, 5.3, 5.5).

As in the thesis a voxel keeps mean vectors, whose lengths tell how far directions are spread (VCT 2.10, Toksvig 2005):
of its normals, here as what faces each of six ways, whose differences are that vector times the area; and of the ways
to where its light comes from. What it sends somewhere is what its surfaces receive of the light's lobe, convolved with
their BRDF. The thesis convolves the lobes of normals and of mirrored light (VCT 2.9, code sample 5.5), as a mirror
reflects, and has Gaussians for all of them. Here surfaces are diffuse, so light is divided among them by what they
receive, and leaves each by the cosine:

- Of the lobe's light a surface of normal n receives E(n), its convolution with the clamped cosine. For any lobe with
  the mean vector D, E(n) - E(-n) = D.n; the sum E(n) + E(-n) is |D.n| where all comes from one direction, and 1/2 where
  it comes from everywhere. In between it is taken for |D.n| + (1 - |D|) / 2: so E(n) = max(D.n, 0) + (1 - |D|) / 4.
- The surfaces that face way w have the normal n_w: along w it is what faces there, along the other axes the difference
  of what faces both ways. So a flat wall, of any slope, has one normal, that from behind too if it is seen from both
  sides; and a ball has six.

The light that goes w is in proportion to what faces there, times E(n_w). So a flat wall sends alike whatever lights it,
the two sides of a curtain send what each receives, and even light stays even; all light that came is sent. One Gaussian
for all normals would be even for a curtain, of which 14 % as much went through as is reflected.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .facing import FacingVoxels
from .pyramid import facing_levels, sample
from .surfaces import DIRECTIONS

LEAST = 1e-3
"""Of E, so that light goes somewhere when, by rounding, no surface faces it: half a step of a moment in 8 bits."""
_TINY = 1e-9  # of what is divided by


def shares_of_ways(facing, comes_from) -> np.ndarray:
    """Of a voxel's light, what goes each way: (m, 6), 1 together.

    facing: (m, 6), along each of DIRECTIONS.  comes_from: (m, 3), mean vectors of the ways to the light.
    """
    facing, light = np.asarray(facing, dtype=np.float64), np.asarray(comes_from, dtype=np.float64)
    spread = 0.25 * np.maximum(1.0 - np.linalg.norm(light, axis=-1, keepdims=True), 0.0)
    net = facing[:, 0::2] - facing[:, 1::2]
    normals = np.repeat(net[:, None], 6, axis=1)
    for way in range(6):
        normals[:, way, way // 2] = DIRECTIONS[way, way // 2] * facing[:, way]
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), _TINY)
    received = np.maximum(np.einsum("mwa,ma->mw", normals, light), 0.0) + spread
    sent = facing * np.maximum(received, LEAST)
    return sent / np.maximum(sent.sum(axis=-1, keepdims=True), _TINY)


def lobes_of(normals, flux, to_light) -> tuple[np.ndarray, np.ndarray]:
    """What a surface of unit normals (m, 3) that reflects `flux` (m, k), of light from unit vectors `to_light` (m, 3),
    adds to its voxel: light (m, k) and moment (m, 3), over pi edge^2.

    Light is the sum of the six intensities, F |n_a| / (pi edge^2), that axial values would have (facing.py): flux times
    the sections that it goes through. The moment is the mean of the channels times the way to the light.
    """
    light = np.abs(normals).sum(axis=-1, keepdims=True) * np.asarray(flux, dtype=np.float64)
    return light, light.mean(axis=-1, keepdims=True) * np.asarray(to_light, dtype=np.float64)


def coarser_light(light, facing, coarser) -> np.ndarray:
    """Light, or moments, [z][y][x][k] of the next level from those of this one. facing, coarser: of both [z][y][x][6].

    The mean radiance, weighed with opacities (VCT 5.4.3), times the coarser opacity: what shines evenly shines as
    evenly from every level.
    """
    weight, total = _eights(facing.sum(axis=-1, keepdims=True)), _eights(np.asarray(light, dtype=np.float64))
    mean = total / np.where(weight > 0.0, weight, 1.0)
    return mean * coarser.sum(axis=-1, keepdims=True)


def _eights(values: np.ndarray) -> np.ndarray:
    """Sums of each 2^3 voxels."""
    n = len(values) // 2
    return values.reshape(n, 2, n, 2, n, 2, -1).sum(axis=(1, 3, 5))


def light_levels(light, facings: Sequence[np.ndarray]) -> list[np.ndarray]:
    """float64 [z][y][x][k] on every level. facings: of the levels."""
    levels = [np.asarray(light, dtype=np.float64)]
    for facing, coarser in pairwise(facings):
        levels.append(coarser_light(levels[-1], facing, coarser))
    return levels


class LobeVoxels(FacingVoxels):
    """A cones.Read, as FacingVoxels, of what voxels send as lobes.

    facing: [z][y][x][6], opacities.  light: [z][y][x][k], radiance times the sum of `facing`; moment: [z][y][x][3]
    (`lobes_of`). All of level 0, cubes of 2^depth.
    """

    def __init__(self, facing, light, moment):
        facings = facing_levels(facing)
        lights, moments = light_levels(light, facings), light_levels(moment, facings)
        self.levels = list(zip(facings, lights, moments, strict=True))
        self.n = len(facings[0])

    def met(self, level, points, towards):
        facing, light, moment = (sample(values, points) for values in level)
        against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
        comes_from = moment / np.maximum(light.mean(axis=-1, keepdims=True), _TINY)
        share = np.einsum("mf,mf->m", against, shares_of_ways(facing, comes_from))
        return share[:, None] * light, np.einsum("mf,mf->m", against, facing)
