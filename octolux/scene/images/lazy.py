"""Images whose pixels are made when they are first asked for: a texture that is in the cache never needs them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..materials import Image


class LazyImage(Image):
    """An image of known size and content.

    size: width and height, pixels.  key: names the content; equal keys mean equal pixels, in every process.
    make: returns the pixels, uint8 (height, width, 4). Called when they are first asked for, by any thread, and
    possibly by two at once.
    """

    def __init__(self, size: tuple[int, int], key: str, make: Callable[[], np.ndarray], name: str = ""):
        # A frozen dataclass: its own __init__, which wants the pixels, is not called.
        for attribute, value in {"_size": size, "_key": key, "name": name, "_make": make}.items():
            object.__setattr__(self, attribute, value)

    @cached_property
    def pixels(self) -> np.ndarray:
        return self._make()  # type: ignore[attr-defined]

    @property
    def size(self) -> tuple[int, int]:
        return self._size  # type: ignore[attr-defined]

    @property
    def key(self) -> str:
        return self._key  # type: ignore[attr-defined]
