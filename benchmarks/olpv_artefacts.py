"""`python -m benchmarks.olpv_artefacts`: the artefacts of OLPV 6.1 and 6.2 by technique, in one table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from . import written_tables
from .olpv_jumps import THESIS, UNIFORMS, back_share, largest_jumps
from .olpv_rooms import OCCLUDED, OPEN, bleeding, temporal_jump

TITLES = ("technique", "jump at wall", "jump at element", "jump in time", "behind source", "wall of 0.4 cells",
          "wall of 2 cells")  # fmt: skip
_ORDER = (THESIS, OCCLUDED[0], "octree-lpv:steps", OCCLUDED[1], OPEN, "octree-lpv", *UNIFORMS)


def rows() -> list[tuple[str, ...]]:
    """The artefacts' table, titles first: jumps in stops, the rest as shares. Jumps in space and light behind its
    source are of light in the open, so that occlusion has no part in them."""
    lines = [TITLES]
    for text in _ORDER:
        cells = ["–"] * 3
        if text not in (*OCCLUDED, OPEN):
            jumps = largest_jumps(text)
            cells = [f"{jumps['wall']:.2f}", f"{jumps['element']:.2f}", f"{back_share(text):.4f}"]
        walls = (f"{bleeding(text, thick):.3f}" for thick in (0.4, 2.0))
        lines.append((text, *cells[:2], f"{temporal_jump(text):.2f}", cells[2], *walls))
    return lines


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a file that cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.olpv_artefacts", description=__doc__)
    written_tables.add_options(parser)
    arguments = parser.parse_args(words)

    def work() -> None:
        written_tables.check(arguments)
        titles, *lines = rows()
        data = [dict(zip(titles, line, strict=True)) for line in lines]
        title = "Artefacts: jumps in stops, the others as shares of the light"
        written_tables.give_out(arguments, [(title, [titles, *lines])], {"artefacts": data})

    return written_tables.exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
