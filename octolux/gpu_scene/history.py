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
        material: who keeps surfels of static surfaces forgets them then.

    Instances are known again as the same objects or else, where a pose has replaced them, by their place in
    `Scene.instances`. Transforms are compared by value; meshes, which are frozen, by the identity of their arrays.
    """

    def __init__(self) -> None:
        self.static_version = 0
        self._syncs = 0
        self._drawn: Drawn | None = None
        self._transforms = np.zeros((0, 4, 4))
        self._materials: list[Material | None] = []
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
        changed = np.full(len(old), self._syncs - MOVING_SYNCS, np.int64)  # who appears is static
        changed[known] = self._changed[old[known]]
        moved = np.zeros(len(old), bool)
        moved[known] = (transforms[known] != self._transforms[old[known]]).any(axis=(1, 2))
        forgotten = len(known) < len(old) or bool(np.delete(was_static, old[known]).any())
        for i, j in zip(known.tolist(), old[known].tolist(), strict=True):
            moved[i] |= before is not None and _reshaped(before, j, drawn, i)
            forgotten |= bool(was_static[j]) and (moved[i] or used[i] is not self._materials[j])
        changed[moved] = self._syncs
        self.static_version += int(forgotten)
        self._drawn, self._transforms, self._materials, self._changed = drawn, transforms, used, changed


def _known_again(before: Drawn, now: Drawn) -> np.ndarray:
    """int64 (drawn now,): the number of each instance among those drawn before, -1 for those that were not."""
    by_place = {int(place): j for j, place in enumerate(before.numbers)}
    by_object = {id(instance): j for j, instance in enumerate(before.instances)}
    result = np.full(len(now.instances), -1)
    for i, (place, instance) in enumerate(zip(now.numbers, now.instances, strict=True)):
        j = by_place.get(int(place), -1)
        here = j >= 0 and before.instances[j] is instance  # an object may be listed twice
        result[i] = j if here else by_object.get(id(instance), -1)
    taken = set(result.tolist())
    for new in np.flatnonzero(result < 0):
        j = by_place.get(int(now.numbers[new]), -1)
        result[new] = -1 if j in taken else j
    return result


def _reshaped(before: Drawn, j: int, now: Drawn, i: int) -> bool:
    a, b = before.slots[j].mesh, now.slots[i].mesh
    return a.positions is not b.positions or a.indices is not b.indices
