"""Debug views: what a technique's light cache holds, by name, for looking into it."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from ..scene.errors import OctoluxError

Pixel = tuple[int, int] | None
"""Column and row from the upper left, or the pixel in the middle."""
NONE: Mapping[str, Any] = {}


class DebugViews(Mapping[str, Any]):
    """Views of the last frame by name; each is made when it is asked for: `views["injected"]`.

    A view is a NumPy array, or a list of them. Pictures are float32 (height, width, 3), linear, of which 1 is white.

    makers: of each view.  at_pixel: of those of one pixel, named "NAME:COLUMN:ROW", which they are given; "NAME" alone,
    for which they are given None, is that of the middle.  pictures: names of those that are; others are numbers. Raises
    OctoluxError for a view that there is not.
    """

    def __init__(
        self, makers: Mapping[str, Callable[[], Any]], at_pixel: Mapping[str, Callable[[Pixel], Any]] = NONE,
        pictures: Collection[str] = (),
    ):  # fmt: skip
        self._makers, self._at_pixel, self._pictures = makers, at_pixel, pictures

    def __iter__(self) -> Iterator[str]:
        yield from (*self._makers, *self._at_pixel)

    def __len__(self) -> int:
        return len(self._makers) + len(self._at_pixel)

    def __contains__(self, name: object) -> bool:
        return name in self._makers or name in self._at_pixel

    def __getitem__(self, name: str) -> Any:
        return self._found(name)[1]()

    def is_picture(self, name: str) -> bool:
        """Whether it can be shown as it is. Raises OctoluxError where there is none; nothing is made."""
        return self._found(name)[0] in self._pictures

    def _found(self, name: str) -> tuple[str, Callable[[], Any]]:
        """Without a pixel its name, and what makes it."""
        if name in self._makers:
            return name, self._makers[name]
        if name in self._at_pixel:
            return name, lambda: self._at_pixel[name](None)
        head, *place = name.rsplit(":", 2)
        if head in self._at_pixel and len(place) == 2 and all(text.isdecimal() for text in place):
            return head, lambda: self._at_pixel[head]((int(place[0]), int(place[1])))
        if not len(self):
            raise OctoluxError(f"There is no debug view '{name}': this technique has none.")
        near = difflib.get_close_matches(name, list(self), n=1)
        remedy = f"Did you mean '{near[0]}'?" if near else "--debug list shows what there is."
        raise OctoluxError(f"There is no debug view '{name}'. {remedy}")

    def lines(self) -> list[str]:
        """All names, for people: those that differ in their last part are in one line."""
        heads: dict[str, list[str]] = {}
        for name in self._makers:
            head, colon, last = name.rpartition(":")
            heads.setdefault(head + colon, []).append(last)
        lines = [head + ", ".join(last) if head else "\n".join(last) for head, last in heads.items()]
        return [*"\n".join(lines).splitlines(), *(f"{name}:COLUMN:ROW" for name in self._at_pixel)]
