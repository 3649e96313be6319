"""Tables as text and as Markdown: rows of cells, the first of which are the titles."""

from __future__ import annotations

from collections.abc import Sequence


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Columns padded to equal width; the last is left as it is."""
    shown = [line for line in lines if len(line[1]) <= 40]  # a long message must not stretch its column
    widths = [max(len(line[i]) for line in shown) for i in range(len(lines[0]))]
    return "\n".join("  ".join(w.ljust(n) for w, n in zip(line, widths, strict=True)).rstrip() for line in lines)


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """A table of Markdown."""
    titles, *rows = (f"| {' | '.join(line)} |" for line in lines)
    return "\n".join([titles, "|" + "---|" * len(lines[0]), *rows])
