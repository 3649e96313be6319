"""Undo and redo in bounded memory."""

from __future__ import annotations

import numpy as np

from .state import State


class History:
    """The states before and after the present one, by the name of the action between.

    limit: bytes of arrays that may be kept, each counted once however many states share it. When it is passed the
    oldest states are forgotten; the present one never is.
    """

    def __init__(self, state: State, limit: int):
        self.state, self.limit = state, limit
        self._past: list[tuple[str, State]] = []
        self._future: list[tuple[str, State]] = []

    @property
    def undoable(self) -> list[str]:
        """Names of the actions that can be undone, the newest last."""
        return [name for name, _ in self._past]

    @property
    def redoable(self) -> list[str]:
        """Names of the actions that can be redone, the next one last."""
        return [name for name, _ in self._future]

    def record(self, name: str, state: State) -> None:
        """`state` came of the present one by the action `name`; nothing can be redone now."""
        self._past.append((name, self.state))
        self._future.clear()
        self.state = state
        while self._past and self.bytes() > self.limit:
            del self._past[0]

    def undo(self) -> str | None:
        """Go back by one action; its name, or None where there is none."""
        return self._move(self._past, self._future)

    def redo(self) -> str | None:
        """Go forward by one action that was undone; its name, or None where there is none."""
        return self._move(self._future, self._past)

    def bytes(self) -> int:
        """Memory of all arrays that are kept."""
        distinct: dict[int, np.ndarray] = {}
        for state in (self.state, *(kept for _, kept in (*self._past, *self._future))):
            distinct.update((id(array), array) for array in state.arrays())
        return sum(array.nbytes for array in distinct.values())

    def _move(self, come_from: list[tuple[str, State]], go_to: list[tuple[str, State]]) -> str | None:
        if not come_from:
            return None
        name, state = come_from.pop()
        go_to.append((name, self.state))
        self.state = state
        return name
