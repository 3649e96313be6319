"""The rows of VCT's tables 6.4 to 6.13 (Drinovsky 2013) on this machine, as vct_thesis.py has those of the thesis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

from . import vct_thesis as thesis
from .registry import figure
from .vct_frames import COPIES, DEPTH, OCTREE, Built, Case, built, frames_of

FRAMES = 3
DEPTHS, MEMORY_DEPTHS = (6, 7, 8), (7, 8, 9)
_FEW = 64
"""Texels, or pixels, of what a table is not about."""

BUILDING = (thesis.FRAGMENTS, thesis.BUILD)
FILLING = (thesis.RESET, thesis.LEAVES, thesis.CHILDREN, COPIES)
INJECTION = (thesis.RENDER, thesis.TRAVERSE, thesis.INSERT, thesis.LIST, thesis.CHILDREN, COPIES)
HELD, BRICKS = "rest, MB", "bricks"

Row = dict[str, float]
Measured = dict[str, dict[str, Row]]
"""As vct_thesis.Rows; by our names of scenes."""


@cache
def _built(scene: str, count: int) -> list[Built]:
    return built(scene, [(thesis.AXIAL, depth) for depth in DEPTHS], count)


@cache
def _by_depth(scene: str, count: int) -> list[Row]:
    return frames_of(scene, [Case(f"depth={depth}") for depth in DEPTHS], count)


def _sum(parts: Mapping[str, float], names: Sequence[str]) -> float:
    return sum(parts.get(name, 0.0) for name in names)


def _octree(parts: Row) -> Row:
    """Of building one: the parts that are so, and their total."""
    found = {part: parts[OCTREE + part] for part in (*BUILDING, *FILLING)}
    return {**found, thesis.TOTAL: sum(found.values())}


def _steps(frame: Row, static: Built) -> Row:
    """The columns of tables 6.4, 6.5 and 6.9. The total is that of a frame, in which only what moves is built."""
    once, moving = _octree(static.parts), _octree(frame)
    found = {
        thesis.MOVING_BUILD: _sum(moving, BUILDING), thesis.MOVING_FILL: _sum(moving, FILLING),
        thesis.INJECT: _sum(frame, INJECTION), thesis.DIFFUSE: frame[thesis.DIFFUSE],
        thesis.SPECULAR: frame[thesis.SPECULAR],
    }  # fmt: skip
    return {
        thesis.BUILD: _sum(once, BUILDING), thesis.FILL: _sum(once, FILLING), **found,
        thesis.TOTAL: sum(found.values()),
    }  # fmt: skip


def depth(scene: str, count: int) -> dict[str, Row]:
    """Table 6.9."""
    pairs = zip(DEPTHS, _by_depth(scene, count), _built(scene, count), strict=True)
    return {str(levels): _steps(frame, octree) for levels, frame, octree in pairs}


def steps(scene: str, count: int) -> dict[str, Row]:
    """Table 6.4."""
    return {"8": depth(scene, count)["8"]}


def representations(scene: str, count: int) -> dict[str, Row]:
    """Table 6.5."""
    kinds = (thesis.AXIAL, thesis.LOBES)
    frames = frames_of(scene, [Case(f"representation={kind}") for kind in kinds], count)
    octrees = built(scene, [(kind, DEPTH) for kind in kinds], count)
    return {kind: _steps(*pair) for kind, *pair in zip(kinds, frames, octrees, strict=True)}


def memory(scene: str, count: int) -> dict[str, Row]:
    """Table 6.6: of the texture that holds the bricks, and all else of the octree."""
    kinds = [(kind, depth) for kind in (thesis.AXIAL, thesis.LOBES) for depth in MEMORY_DEPTHS]
    octrees = zip(kinds, built(scene, kinds, 1), strict=True)
    return {
        f"{kind} {depth}": {"MB": one.megabytes, HELD: one.other_megabytes, BRICKS: one.bricks}
        for (kind, depth), one in octrees
    }


def resolution(scene: str, count: int) -> dict[str, Row]:
    """Table 6.7."""
    cases = [Case(size=size, shadows=_FEW) for size in thesis.SIZES]
    names = [f"{w}x{h}" for w, h in thesis.SIZES]
    return _columns(names, frames_of(scene, cases, count), (thesis.DIFFUSE, thesis.SPECULAR))


def shadow_maps(scene: str, count: int) -> dict[str, Row]:
    """Table 6.8, but of one shadow map, as the texels of six that are so large are more VPLs than there can be."""
    cases = [Case(size=(_FEW, _FEW), shadows=texels, faces=1) for texels in thesis.SHADOWS]
    names = [str(texels) for texels in thesis.SHADOWS]
    return _columns(names, frames_of(scene, cases, count), (thesis.RENDER, thesis.TRAVERSE))


def cones(scene: str, count: int) -> dict[str, Row]:
    """Table 6.10."""
    cases = [Case(f"cones={number}", shadows=_FEW) for number in thesis.CONES]
    return _columns([str(n) for n in thesis.CONES], frames_of(scene, cases, count), (thesis.DIFFUSE,))


def static(scene: str, count: int) -> dict[str, Row]:
    """Table 6.11."""
    octrees = zip(DEPTHS, _built(scene, count), strict=True)
    return {str(levels): {**_octree(one.parts), thesis.NODES: one.nodes} for levels, one in octrees}


def moving(scene: str, count: int) -> dict[str, Row]:
    """Table 6.12. Here no update list is made: all bricks of what moves are made anew."""
    return {str(levels): _octree(frame) for levels, frame in zip(DEPTHS, _by_depth(scene, count), strict=True)}


def injection(scene: str, count: int) -> dict[str, Row]:
    """Table 6.13."""
    frames = [{**frame, thesis.TOTAL: _sum(frame, INJECTION)} for frame in _by_depth(scene, count)]
    return _columns([str(levels) for levels in DEPTHS], frames, (*INJECTION, thesis.TOTAL))


def _columns(keys: Sequence[str], frames: Sequence[Row], columns: Sequence[str]) -> dict[str, Row]:
    return {key: {c: frame[c] for c in columns if c in frame} for key, frame in zip(keys, frames, strict=True)}


Measure = Callable[[str, int], dict[str, Row]]
TABLES: dict[str, tuple[str, str, Measure, thesis.Rows]] = {
    "6.4": ("Steps of a frame, and their share of it", "depth", steps, thesis.BY_DEPTH),
    "6.5": ("Steps of a frame by what voxels keep of light", "light", representations, thesis.BY_REPRESENTATION),
    "6.6": ("Memory of bricks", "light, depth", memory, thesis.MEMORY),
    "6.7": ("Cones by the picture's pixels", "pixels", resolution, thesis.BY_SIZE),
    "6.8": ("One shadow map by its texels, all injected; six in VCT", "texels", shadow_maps, thesis.BY_SHADOWS),
    "6.9": ("Steps of a frame by depth", "depth", depth, thesis.BY_DEPTH),
    "6.10": ("Diffuse cones by their number", "cones", cones, thesis.BY_CONES),
    "6.11": ("Voxelisation of what is static", "depth", static, thesis.STATIC_PARTS),
    "6.12": ("Voxelisation of what moves", "depth", moving, thesis.MOVING_PARTS),
    "6.13": ("Injection of light", "depth", injection, thesis.INJECTION_PARTS),
}  # fmt: skip
"""Title, what rows vary, ours, the thesis's."""


@figure("vct_table_6_9", group="vct", unit="ms")
def vct_table_6_9() -> dict[str, float]:
    """Table 6.9 of VCT in the Cornell box from a few frames; python -m benchmarks.vct_tables has all tables."""
    found = depth("cornell-box", FRAMES)
    return {f"{key}.{column.replace(' ', '_')}": ms for key, row in found.items() for column, ms in row.items()}
