"""What tests ask of meshes."""

from __future__ import annotations

import numpy as np

from octolux.scene.meshes import Mesh


def triangles(mesh: Mesh) -> np.ndarray:
    return mesh.positions[mesh.indices].astype(np.float64)


def face_normals(mesh: Mesh) -> np.ndarray:
    """Unit normals (triangles, 3); every triangle of these shapes has an area."""
    a, b, c = np.moveaxis(triangles(mesh), 1, 0)
    cross = np.cross(b - a, c - a)
    return cross / np.linalg.norm(cross, axis=1, keepdims=True)


def signed_volume(mesh: Mesh) -> float:
    """Positive when a closed surface is seen from outside."""
    a, b, c = np.moveaxis(triangles(mesh), 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
