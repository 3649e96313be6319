"""Warnings of a loader, one line of each kind."""

from __future__ import annotations

import re

_PLACE = re.compile(r"([a-z]+ \d+(?: [a-z]+ \d+)*(?:: \w+)*): ")


def merged(warnings: list[str]) -> list[str]:
    """The lines in order of their first appearance; those that say the same of several places become one.

    "mesh 0 primitive 1: lines are left out", said of two more, becomes "mesh 0 primitive 1 and 2 more places: ...".
    """
    places: dict[str, list[str]] = {}
    for line in warnings:
        found = _PLACE.match(line)
        places.setdefault(line[found.end() :] if found else line, []).append(found[1] if found else "")
    return [_line(text, list(dict.fromkeys(where))) for text, where in places.items()]


def _line(text: str, places: list[str]) -> str:
    if places == [""]:
        return text
    more = f" and {len(places) - 1} more places" if len(places) > 2 else f" and {places[1]}" if len(places) > 1 else ""
    return f"{places[0]}{more}: {text}"
