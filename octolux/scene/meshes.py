"""Meshes and instances: triangles in object space and where they stand in the world."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .python.arrays import mesh_arrays


@dataclass(frozen=True, eq=False, kw_only=True)
class MorphTarget:
    """Displacements float32 (vertices, 3) that a weight adds to positions, normals and tangents; None is none."""

    positions: np.ndarray | None = None
    normals: np.ndarray | None = None
    tangents: np.ndarray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Deformable:
    """A mesh as it was modelled, and what moves its vertices: first the morph targets, then the skin.

    positions, normals: float32 (vertices, 3).  tangents: float32 (vertices, 4).
    joints: uint16 (vertices, k), positions in the skin's list of joints.  weights: float32 (vertices, k), sum 1.
    """

    positions: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray
    targets: tuple[MorphTarget, ...] = ()
    joints: np.ndarray | None = None
    weights: np.ndarray | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Mesh:
    """Triangles of one material.

    positions: float32 (vertices, 3), metres, object space.
    normals: float32 (vertices, 3), unit length, shading normals.
    uvs: float32 (vertices, 2), (0, 0) at the image's upper left.
    tangents: float32 (vertices, 4), glTF: xyz unit length, w = +1 or -1 the sign of the bitangent cross(n, t) * w.
    indices: uint32 (triangles, 3), counter-clockwise seen from the front.
    material: index into `Scene.materials`.
    colors: float32 (vertices, 4), linear, multiply the material's base colour and alpha; None is white.
    deformable: set for meshes that a skin or morph targets deform; the arrays above then hold the present pose.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    tangents: np.ndarray
    indices: np.ndarray
    material: int = 0
    name: str = ""
    colors: np.ndarray | None = None
    deformable: Deformable | None = None

    def __post_init__(self) -> None:
        count = len(self.positions)
        expected = {"positions": 3, "normals": 3, "uvs": 2, "tangents": 4, "colors": 4}
        for attribute, width in expected.items():
            array = getattr(self, attribute)
            if attribute == "colors" and array is None:
                continue
            if array.dtype != np.float32 or array.shape != (count, width):
                raise ValueError(
                    f"mesh '{self.name}': {attribute} must be float32 ({count}, {width}), "
                    f"got {array.dtype} {array.shape}"
                )
        if self.indices.dtype != np.uint32 or self.indices.ndim != 2 or self.indices.shape[1] != 3:
            raise ValueError(f"mesh '{self.name}': indices must be uint32 (triangles, 3)")
        if self.indices.size and int(self.indices.max()) >= count:
            raise ValueError(f"mesh '{self.name}': index {int(self.indices.max())} of only {count} vertices")

    @classmethod
    def from_arrays(cls, positions: Any, indices: Any, normals: Any = None, uvs: Any = None, colors: Any = None,
                    material: int = 0, name: str = "") -> Mesh:
        """A mesh from arrays of any numeric type; they are copied.

        positions, normals: (vertices, 3), metres; normals of any length, made smooth with edges above 52.5 degrees
            when None, for which vertices may be split.
        indices: (triangles, 3) or flat, whole numbers, counter-clockwise seen from the front.
        uvs: (vertices, 2), (0, 0) at the image's upper left.
        colors: (vertices, 3 or 4); floats are linear in [0, 1], whole numbers sRGB in [0, the type's largest].

        Raises OctoluxError that names the array and what is wrong with it.
        """
        return cls(**mesh_arrays(positions, indices, normals, uvs, colors), material=material, name=name)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class Instance:
    """A mesh placed in the world.

    transform: float64 (4, 4), object to world, column vectors. With a skin it only says in which space the mesh's
        vertices are kept; joints place them in the world.
    node: index into `Scene.nodes` whose place it takes when the scene moves, or None.
    skin: index into `Scene.skins`, or None.  morph_weights: one for each of the mesh's morph targets.
    A deformable mesh belongs to one instance alone.
    """

    mesh: int
    transform: np.ndarray = field(default_factory=lambda: np.eye(4))
    name: str = ""
    node: int | None = None
    skin: int | None = None
    morph_weights: tuple[float, ...] = ()
