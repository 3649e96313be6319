"""What deforms a glTF primitive: morph targets, joints and weights (glTF 2.0, sections 3.7.2.2 and 3.7.3.3)."""

from __future__ import annotations

import numpy as np

from ..meshes import MorphTarget
from ..motion.movers import Movers
from .accessors import Accessors, require
from .json import Fields

_DISPLACED = {"POSITION": "positions", "NORMAL": "normals", "TANGENT": "tangents"}


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
        count = int((sums == 0).sum())
        warnings.append(f"{attributes.place}: {count} vertices have no weight; they follow their first joint")
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
