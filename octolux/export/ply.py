"""Meshes as binary PLY, in world space."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..scene.meshes import Mesh


def world_arrays(mesh: Mesh, transform: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions (vertices, 3), unit normals (vertices, 3), float64, and indices (triangles, 3) of a mesh placed by
    `transform` (4, 4). Triangles of a mirrored mesh are turned round, so that their fronts stay fronts."""
    linear = np.asarray(transform, dtype=np.float64)[:3, :3]
    positions = mesh.positions.astype(np.float64) @ linear.T + transform[:3, 3]
    mirrored = np.linalg.det(linear) < 0
    # Normals go with the cofactor matrix, which exists for a flat transform too; its sign is the determinant's.
    cofactor = np.stack([np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)])
    normals = mesh.normals.astype(np.float64) @ cofactor.T * (-1.0 if mirrored else 1.0)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 0, normals / np.where(length > 0, length, 1.0), mesh.normals)
    return positions, normals, mesh.indices[:, ::-1] if mirrored else mesh.indices


def write_ply(path: Path, positions: np.ndarray, normals: np.ndarray, indices: np.ndarray, uvs: np.ndarray,
              colors: np.ndarray | None = None) -> None:  # fmt: skip
    """positions, normals (vertices, 3), uvs (vertices, 2), colors (vertices, 3) or None, all written as float32;
    indices (triangles, 3). Mitsuba's names: `s`, `t`, and `color_0` to `color_2` for the attribute `vertex_color`.
    Raises OSError.
    """
    columns = [positions, normals, uvs] + ([] if colors is None else [colors])
    names = ["x", "y", "z", "nx", "ny", "nz", "s", "t"] + ([] if colors is None else [f"color_{i}" for i in range(3)])
    faces = np.zeros(len(indices), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, indices
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    with path.open("wb") as file:
        file.write("\n".join(header).encode("ascii"))
        file.write(np.hstack(columns).astype("<f4").tobytes())
        file.write(faces.tobytes())
