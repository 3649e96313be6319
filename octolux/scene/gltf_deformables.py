"""What deforms a glTF primitive: morph targets, joints and weights (glTF 2.0, sections 3.7.2.2 and 3.7.3.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from . import geometry
from .gltf_accessors import Accessors, require
from .gltf_json import Fields
from .meshes import Deformable, MorphTarget

_DISPLACED = {"POSITION": "positions", "NORMAL": "normals", "TANGENT": "tangents"}


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


def read_movers(primitive: Fields, attributes: Fields, accessors: Accessors, count: int, warnings: list[str]) -> Movers:
    """What deforms a primitive of `count` vertices. Raises SceneError."""
    targets = tuple(_target(fields, accessors, count, warnings) for fields in primitive.children("targets", "target"))
    return Movers(targets, *_joints(attributes, accessors, count, warnings))


def _target(fields: Fields, accessors: Accessors, count: int, warnings: list[str]) -> MorphTarget:
    arrays: dict[str, np.ndarray] = {}
    for key in fields.values:
        if key not in _DISPLACED:
            warnings.append(f"{fields.place}: displacements of {key} are left out")
            continue
        values = accessors.vectors(require(fields, fields.index(key, len(accessors), "accessor"), key), 3)
        _check_count(fields, key, len(values), count)
        if values.any():
            arrays[_DISPLACED[key]] = values
    return MorphTarget(**arrays)


def _flat_target(target: MorphTarget, positions: np.ndarray, normals: np.ndarray, indices: np.ndarray) -> MorphTarget:
    if target.positions is None:
        return MorphTarget()
    faces = geometry.unit(geometry.face_vectors(positions + target.positions, indices), fallback=(0.0, 1.0, 0.0))
    return MorphTarget(positions=target.positions, normals=np.repeat(faces.astype(np.float32), 3, axis=0) - normals)


def _joints(attributes: Fields, accessors: Accessors, count: int,
            warnings: list[str]) -> tuple[np.ndarray | None, np.ndarray | None]:
    """joints uint16 and weights float32 (vertices, k), sum 1, of all sets; None and None when there are none."""
    sets: list[tuple[np.ndarray, np.ndarray]] = []
    while f"JOINTS_{len(sets)}" in attributes or f"WEIGHTS_{len(sets)}" in attributes:
        sets.append(_joint_set(attributes, accessors, len(sets), count))
    if not sets:
        return None, None
    joints, weights = (np.hstack(arrays) for arrays in zip(*sets, strict=True))
    sums = weights.sum(axis=1, keepdims=True)
    if not sums.all():
        warnings.append(f"{attributes.place}: {int((sums == 0).sum())} vertices have no weight; they follow joint 0")
        weights[:, :1], sums = np.where(sums > 0, weights[:, :1], 1.0), np.where(sums > 0, sums, 1.0)
    used = weights.any(axis=0)
    # Files may have any number beside a weight of zero.
    return np.where(weights > 0, joints, 0)[:, used].astype(np.uint16), (weights / sums)[:, used].astype(np.float32)


def _joint_set(attributes: Fields, accessors: Accessors, number: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    arrays = []
    for name, read in ((f"JOINTS_{number}", accessors.joints), (f"WEIGHTS_{number}", accessors.weights)):
        arrays.append(read(require(attributes, attributes.index(name, len(accessors), "accessor"), name)))
        _check_count(attributes, name, len(arrays[-1]), count)
    return arrays[0], arrays[1]


def _check_count(fields: Fields, key: str, found: int, count: int) -> None:
    if found != count:
        raise fields.error(f"{key} has {found} elements, POSITION has {count}")
