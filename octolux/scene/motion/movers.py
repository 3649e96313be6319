"""What deforms a mesh, while the mesh is made: it follows where vertices are copied or shaded flat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry import triangles as geometry
from ..meshes import Deformable, MorphTarget


@dataclass(frozen=True)
class Movers:
    """The arrays of a `Deformable` beside the modelled ones, vertex by vertex."""

    targets: tuple[MorphTarget, ...] = ()
    joints: np.ndarray | None = None
    weights: np.ndarray | None = None

    def take(self, vertices: np.ndarray) -> Movers:
        """Those of a mesh whose vertices are copies of these, int (new vertices,)."""

        def taken(array: np.ndarray | None) -> np.ndarray | None:
            return None if array is None else array[vertices]

        targets = (MorphTarget(positions=taken(t.positions), normals=taken(t.normals), tangents=taken(t.tangents))
                   for t in self.targets)
        return Movers(tuple(targets), taken(self.joints), taken(self.weights))

    def flat(self, positions: np.ndarray, normals: np.ndarray, indices: np.ndarray) -> Movers:
        """Those of a flat-shaded mesh: each target's normals are flat in the target's own shape, and tangents are not
        displaced (section 3.7.2.2). The arrays are the mesh's, as `geometry.flat` gives them."""
        return Movers(tuple(_flat_target(t, positions, normals, indices) for t in self.targets),
                      self.joints, self.weights)  # fmt: skip

    def deformable(self, positions: np.ndarray, normals: np.ndarray, tangents: np.ndarray) -> Deformable | None:
        """The mesh as it was modelled, or None when nothing deforms it."""
        if not self.targets and self.joints is None:
            return None
        return Deformable(positions=positions, normals=normals, tangents=tangents, targets=self.targets,
                          joints=self.joints, weights=self.weights)  # fmt: skip


def _flat_target(target: MorphTarget, positions: np.ndarray, normals: np.ndarray, indices: np.ndarray) -> MorphTarget:
    if target.positions is None:
        return MorphTarget()
    faces = geometry.unit(geometry.face_vectors(positions + target.positions, indices), fallback=(0.0, 1.0, 0.0))
    return MorphTarget(positions=target.positions, normals=np.repeat(faces.astype(np.float32), 3, axis=0) - normals)
