"""Which tangents a mesh gets where its file has none."""

from __future__ import annotations

import numpy as np

from . import mikktspace
from .mikktspace import TangentSpace
from .triangles import tangents


def tangent_space(
    positions: np.ndarray, normals: np.ndarray, uvs: np.ndarray, indices: np.ndarray, normal_map: bool
) -> TangentSpace:
    """A mesh's tangents, arguments as `mikktspace.generate`.

    normal_map: whether the material has one. It is baked for MikkTSpace's tangents, for which vertices are split;
    without one tangents only have to be orthogonal to the normal, and vertices stay as they are.
    """
    if normal_map:
        return mikktspace.generate(positions, normals, uvs, indices)
    return TangentSpace(np.arange(len(positions)), indices, tangents(positions, normals, uvs, indices))
