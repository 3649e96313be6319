"""Which instances move, from what one sync after another has brought: light caches keep surfels of what is static."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..scene.materials import Material

if TYPE_CHECKING:
    from .instances import Drawn

MOVING_SYNCS = 8
"""An instance counts as moving in the sync that brings a change and in the seven that follow."""


class InstanceHistory:
    """An instance is static until its transform or the shape of its mesh first changes, and again when neither has in
    the last MOVING_SYNCS syncs.

    moving: bool (drawn instances,).
    static_version: grows with every sync in which something static began to move, appeared, vanished or got another
        material or mesh: who keeps surfels of static surfaces forgets them then.
    left: bool (instances drawn before that sync,), which of the static ones were no longer what and where they were.
    has_changed: bool (drawn instances,), whose transform, mesh or material has ever been another since it appeared.
    lasting_version: grows with every sync in which something that had not changed did, or vanished, or in which
        something appeared: who keeps what is made of all that has not makes it anew then.

    Instances are known again as the same objects or else, where a pose has replaced them, by their place in
    `Scene.instances`. Transforms are compared by value; meshes, which are frozen, by the identity of their arrays.
    """

    def __init__(self) -> None:
        self.static_version = self.lasting_version = 0
        self.left = np.zeros(0, bool)
        self.has_changed = np.zeros(0, bool)
        self._syncs = 0
        self._drawn: Drawn | None = None
        self._transforms = np.zeros((0, 4, 4))
        self._materials: list[Material | None] = []  # of each drawn instance
        self._changed = np.zeros(0, np.int64)  # the sync in which each drawn instance last changed

    @property
    def moving(self) -> np.ndarray:
        return self._syncs - self._changed < MOVING_SYNCS

    def wait(self) -> None:
        """A sync without any change."""
        self._syncs += 1

    def see(self, drawn: Drawn, transforms: np.ndarray, materials: Sequence[Material]) -> None:
        """A sync that may have changed something. transforms: float64 (drawn instances, 4, 4), to world."""
        before, was_static = self._drawn, ~self.moving
        self._syncs += 1
        used = [materials[slot.mesh.material] if materials else None for slot in drawn.slots]
        old = np.full(len(used), -1) if before is None else _known_again(before, drawn)
        known = np.flatnonzero(old >= 0)
        old = old[known]
        changed = np.full(len(used), self._syncs - MOVING_SYNCS, np.int64)  # who appears is static
        changed[known] = self._changed[old]
        moved, forgotten = np.zeros(len(used), bool), np.zeros(len(was_static), bool)
        ever = np.zeros(len(used), bool)
        if before is not None:
            moved[known] = (transforms[known] != self._transforms[old]).any(axis=(1, 2))
            moved[known] |= _reshaped(before, old, drawn, known)
            forgotten[old] = moved[known] | (_ids(self._materials)[old] != _ids(used)[known])
            forgotten[old] |= _mesh_ids(before)[old] != _mesh_ids(drawn)[known]
            ever[known] = self.has_changed[old] | forgotten[old]
            forgotten |= np.bincount(old, minlength=len(forgotten)) == 0  # has vanished
        changed[moved] = self._syncs
        appeared = len(known) < len(used)
        if appeared or (forgotten & was_static).any():
            self.static_version, self.left = self.static_version + 1, forgotten & was_static
        self.lasting_version += bool(appeared or (forgotten & ~self.has_changed).any())
        self.has_changed = ever
        self._drawn, self._transforms, self._materials, self._changed = drawn, transforms, used, changed


def _ids(objects: Sequence[object]) -> np.ndarray:
    """Identities, to compare many at once; of objects that are kept alive."""
    return np.fromiter(map(id, objects), np.int64, len(objects))


def _mesh_ids(drawn: Drawn) -> np.ndarray:
    return _ids([slot.mesh for slot in drawn.slots])


def _known_again(before: Drawn, now: Drawn) -> np.ndarray:
    """int64 (drawn now,): the number of each instance among those drawn before, -1 for those that were not."""
    by_place = {place: j for j, place in enumerate(before.numbers.tolist())}
    result = np.array([by_place.get(place, -1) for place in now.numbers.tolist()], np.int64)
    objects, here = _ids(before.instances), np.flatnonzero(result >= 0)
    others = np.ones(len(result), bool)  # than those that stand where they stood; an object may be listed twice
    others[here] = objects[result[here]] != _ids(now.instances)[here]
    by_object = {number: j for j, number in enumerate(objects.tolist())} if others.any() else {}
    found = {i: by_object.get(id(now.instances[i]), -1) for i in np.flatnonzero(others).tolist()}
    taken = {*result[~others].tolist(), *found.values()}
    for i, j in found.items():
        replaced = j < 0 and int(result[i]) not in taken
        result[i] = result[i] if replaced else j
    return result


def _reshaped(before: Drawn, old: np.ndarray, now: Drawn, new: np.ndarray) -> np.ndarray:
    """bool: whether the mesh of instances `new` has other positions or triangles than that of `old` before."""
    result = _ids(before.slots)[old] != _ids(now.slots)[new]
    for k in np.flatnonzero(result):
        a, b = before.slots[old[k]].mesh, now.slots[new[k]].mesh
        result[k] = a.positions is not b.positions or a.indices is not b.indices
    return result
