"""What VCT (Drinovsky 2013) prints in its tables 6.4 to 6.13, of the scenes that are here too, on its GTX 660.

Milliseconds, and megabytes. Tables are by scene; in each by what they vary, where they vary something, and by column.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

SCENES = ("Cornell box", "Dungeon", "Sponza")
ADAPTER = "GTX 660"

Rows = dict[str, dict[str, dict[str, float]]]
"""Scene, what is varied, column."""

BUILD, FILL, INJECT, DIFFUSE, SPECULAR, TOTAL = (
    "Oct. build", "Brick fill", "L. inject.", "VCT diff.", "VCT spec.", "Total",
)  # fmt: skip
MOVING_BUILD, MOVING_FILL = "Dyn. oct. build", "Dyn. brick fill"
STEPS = (BUILD, FILL, MOVING_BUILD, MOVING_FILL, INJECT, DIFFUSE, SPECULAR, TOTAL)
"""Of a frame: the total is without the static part's building and filling, which is done once."""

FRAGMENTS, RESET, LEAVES, INSIDE, CHILDREN, EDGES, LIST = (
    "VFL gen.", "Reset bricks", "Gather VF", "CP inside", "Gather ch.", "CP edge", "Upd. list",
)  # fmt: skip
STATIC = (FRAGMENTS, BUILD, RESET, LEAVES, INSIDE, CHILDREN, EDGES, TOTAL)
MOVING = (*STATIC[:-1], LIST, TOTAL)
RENDER, TRAVERSE, INSERT = "SM render", "Trav. SM", "Insert val."
INJECTION = (RENDER, TRAVERSE, INSERT, LIST, RESET, INSIDE, CHILDREN, EDGES, TOTAL)
NODES = "Nodes"


def _rows(columns: Sequence[str], table: Mapping[str, Mapping[object, Sequence[float]]]) -> Rows:
    return {
        scene: {str(key): dict(zip(columns, line, strict=True)) for key, line in lines.items()}
        for scene, lines in table.items()
    }  # fmt: skip


def _turned(keys: Sequence[object], columns: Sequence[str], table: Mapping[str, Sequence[float]]) -> Rows:
    """Of tables that have all keys behind one another in a line, each with all columns."""
    wide = len(columns)
    return _rows(columns, {
        scene: {key: line[wide * i : wide * (i + 1)] for i, key in enumerate(keys)} for scene, line in table.items()
    })  # fmt: skip


BY_DEPTH = _rows(STEPS, {
    "Cornell box": {6: (8.13, 4.56, 2.86, 8.95, 14.07, 6.55, 4.60, 37.04),
                    7: (10.35, 14.30, 3.55, 21.34, 27.96, 6.52, 8.49, 67.87),
                    8: (18.76, 51.49, 4.92, 70.61, 77.75, 9.87, 7.43, 170.59)},
    "Dungeon": {6: (7.50, 3.97, 2.69, 7.23, 13.24, 9.25, 8.78, 41.19),
                7: (11.42, 12.83, 3.50, 15.56, 22.31, 11.90, 10.83, 64.10),
                8: (18.68, 45.05, 4.75, 43.85, 48.70, 14.73, 10.65, 122.68)},
    "Sponza": {6: (9.78, 5.80, 2.74, 6.88, 10.40, 10.86, 8.13, 39.01),
               7: (16.11, 20.59, 3.65, 13.95, 17.80, 14.00, 12.30, 61.69),
               8: (31.81, 81.79, 4.09, 36.86, 40.90, 17.22, 14.09, 113.15)},
})  # fmt: skip
"""Table 6.9; its rows of depth 8 are those of 6.4 for this adapter."""

AXIAL, LOBES = "axial", "lobes"
BY_REPRESENTATION = _rows(STEPS, {
    "Cornell box": {AXIAL: (12.7242, 51.16, 3.07, 67.49, 75.85, 10.63, 7.92, 164.96),
                    LOBES: (17.42828, 63.35, 4.65, 35.73, 42.04, 11.56, 8.78, 102.77)},
    "Dungeon": {AXIAL: (11.8201, 41.86, 3.00, 42.31, 49.38, 13.69, 10.38, 118.77),
                LOBES: (16.87407, 51.32, 4.67, 23.82, 31.81, 15.10, 11.68, 87.08)},
    "Sponza": {AXIAL: (28.4524, 82.22, 2.60, 34.60, 41.05, 16.87, 14.05, 109.18),
               LOBES: (34.1763, 107.10, 4.58, 23.74, 26.14, 20.72, 17.51, 92.70)},
})  # fmt: skip
"""Table 6.5."""

MEMORY = _turned([f"{kind} {depth}" for kind in (AXIAL, LOBES) for depth in (7, 8, 9)], ("MB",), {
    "Cornell box": (24, 84, 323, 24, 60, 204), "Dungeon": (24, 60, 216, 8, 36, 132),
    "Sponza": (24, 108, 431, 24, 72, 276),
})  # fmt: skip
"""Table 6.6."""

SIZES = ((512, 512), (1280, 800), (1600, 1024))
BY_SIZE = _turned([f"{w}x{h}" for w, h in SIZES], (DIFFUSE, SPECULAR), {
    "Cornell box": (10.86, 7.82, 25.85, 17.76, 38.97, 30.15),
    "Dungeon": (13.91, 10.43, 54.57, 42.28, 85.86, 67.47),
    "Sponza": (17.19, 14.07, 63.71, 52.49, 101.19, 82.39),
})  # fmt: skip
"""Table 6.7."""

SHADOWS = (512, 1024, 2048)
BY_SHADOWS = _turned(SHADOWS, (RENDER, TRAVERSE), {
    "Cornell box": (0.41, 5.23, 1.37, 20.14, 5.18, 79.50), "Dungeon": (0.57, 6.83, 2.01, 26.63, 7.61, 105.70),
    "Sponza": (1.15, 2.69, 2.23, 10.17, 6.88, 40.33),
})  # fmt: skip
"""Table 6.8."""

CONES = tuple(range(4, 13))
BY_CONES = _turned(CONES, (DIFFUSE,), {
    "Cornell box": (8.68, 9.58, 9.87, 11.21, 11.97, 13.23, 14.43, 15.58, 15.12),
    "Dungeon": (10.76, 12.07, 14.73, 15.92, 17.40, 18.67, 20.00, 21.89, 22.73),
    "Sponza": (11.67, 14.58, 17.22, 19.35, 21.87, 23.95, 25.93, 27.81, 29.61),
})  # fmt: skip
"""Table 6.10."""

STATIC_PARTS = _rows((*STATIC, NODES), {
    "Cornell box": {6: (0.24, 7.89, 0.35, 0.09, 0.39, 2.57, 1.16, 12.68, 4893),
                    7: (0.83, 9.52, 1.70, 0.44, 1.46, 8.82, 1.87, 24.65, 19045),
                    8: (3.11, 15.64, 5.55, 2.04, 6.05, 33.56, 4.29, 70.25, 77051)},
    "Dungeon": {6: (0.30, 7.21, 0.29, 0.06, 0.29, 2.28, 1.04, 11.48, 3827),
                7: (0.96, 10.46, 1.13, 0.44, 1.18, 8.11, 1.96, 24.25, 15231),
                8: (3.38, 15.30, 4.58, 1.62, 4.91, 30.03, 3.91, 63.73, 62524)},
    "Sponza": {6: (1.77, 8.01, 0.49, 0.16, 0.53, 3.50, 1.12, 15.58, 6698),
               7: (4.38, 11.73, 2.03, 0.72, 2.22, 13.29, 2.34, 36.70, 28343),
               8: (12.24, 19.56, 9.04, 3.39, 10.16, 53.00, 6.20, 113.60, 126639)},
})  # fmt: skip
"""Table 6.11."""

MOVING_PARTS = _rows(MOVING, {
    "Cornell box": {6: (0.29, 2.57, 0.34, 0.04, 0.83, 2.98, 0.96, 3.79, 11.81),
                    7: (0.45, 3.10, 1.29, 0.04, 3.12, 10.55, 1.98, 4.37, 24.90),
                    8: (0.55, 4.37, 5.19, 0.06, 12.82, 41.30, 5.26, 5.99, 75.54)},
    "Dungeon": {6: (0.29, 2.40, 0.25, 0.03, 0.50, 2.08, 0.87, 3.49, 9.92),
                7: (0.38, 3.12, 1.03, 0.05, 1.83, 6.78, 1.58, 4.29, 19.06),
                8: (0.45, 4.30, 4.12, 0.13, 6.76, 23.49, 3.41, 5.96, 48.60)},
    "Sponza": {6: (0.28, 2.47, 0.43, 0.03, 0.32, 1.72, 0.84, 3.54, 9.62),
               7: (0.32, 3.33, 1.82, 0.04, 1.12, 5.20, 1.35, 4.42, 17.59),
               8: (0.29, 3.80, 8.05, 0.07, 3.57, 17.15, 2.54, 5.49, 40.95)},
})  # fmt: skip
"""Table 6.12."""

INJECTION_PARTS = _rows(INJECTION, {
    "Cornell box": {6: (0.46, 3.84, 1.19, 3.50, 0.34, 0.83, 2.99, 0.93, 14.07),
                    7: (0.38, 4.52, 1.61, 4.03, 1.30, 3.25, 10.91, 1.97, 27.96),
                    8: (0.48, 5.21, 2.23, 5.47, 5.17, 12.76, 41.08, 5.34, 77.75)},
    "Dungeon": {6: (0.59, 5.04, 0.97, 3.07, 0.25, 0.45, 2.04, 0.83, 13.24),
                7: (0.57, 5.93, 1.44, 3.96, 1.02, 1.70, 6.22, 1.46, 22.31),
                8: (0.65, 6.81, 2.28, 5.39, 4.19, 5.72, 20.49, 3.16, 48.70)},
    "Sponza": {6: (1.15, 2.06, 0.76, 3.19, 0.43, 0.31, 1.68, 0.81, 10.40),
               7: (1.15, 2.41, 0.84, 3.99, 1.82, 1.07, 4.91, 1.61, 17.80),
               8: (1.18, 2.70, 1.03, 4.85, 8.03, 3.53, 17.07, 2.52, 40.90)},
})  # fmt: skip
"""Table 6.13."""
