"""Propagation of a volume's levels: k steps of face flux and reprojection, and the sum of all of them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, NamedTuple

from ...gpu.bindings import Binding, storage, storage_rw
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...simulator.lpv import transfer
from ...simulator.lpv.bounces import BOUNCES
from .constants import propagation_values
from .levels import ROW, WORKGROUP, Levels

# Cells a thread does: neighbours in y and z share loads, while threads side by side in x read what lies side by side.
# Each cell is a neighbour of another in its block, so all of the block's own cells are read.
BLOCK = (1, 2, 2)
FACE_BLOCK = (2, 2, 8)  # of faces.wgsl, whose threads walk along z
CELL_TYPES = {"f32": "vec4f", "f16": "vec2u", "snorm8": "u32"}
CELL_BYTES = {"f32": 48, "f16": 24, "snorm8": 12}


def _places(block: tuple[int, ...]) -> list[tuple[int, ...]]:
    return list(itertools.product(*(range(b) for b in block)))


def block_sources(block: tuple[int, int, int] = BLOCK) -> list[dict[str, Any]]:
    """Which neighbours a block of cells reads: offset, which of the block's own cells it is (or None), and which cells
    use it how."""
    cells = _places(block)
    sources: dict[tuple[int, ...], list[dict[str, Any]]] = {}
    for number, cell in enumerate(cells):
        for direction in transfer.DIRECTIONS.tolist():
            axis = next(i for i in range(3) if direction[i])
            offset = tuple(c - d for c, d in zip(cell, direction, strict=True))
            use = {"cell": number, "axis": "xyz"[axis], "sign": f"{direction[axis]}.0"}
            sources.setdefault(offset, []).append(use)
    own = {cell: number for number, cell in enumerate(cells)}
    return [{"offset": o, "own": own.get(o), "uses": u} for o, u in sources.items()]


def block_faces(block: tuple[int, int, int] = BLOCK) -> dict[str, Any]:
    """The faces that a block's cells have, each once: its cell, of which it is the lower face across `axis`. And their
    names by cell, axis and whether it is the upper one."""
    met: dict[str, dict[str, Any]] = {}
    names: list[dict[str, list[str]]] = []
    for cell in _places(block):
        names.append({})
        for axis in range(3):
            for upper in range(2):
                at = tuple(c + upper * (k == axis) for k, c in enumerate(cell))
                name = f"face_{'xyz'[axis]}_{at[0]}{at[1]}{at[2]}"
                met[name] = {"name": name, "cell": at, "axis": axis}
                names[-1].setdefault("xyz"[axis], []).append(name)
    return {"faces_met": list(met.values()), "face_names": names}


class Step(NamedTuple):
    """A variant of propagation.wgsl. first: reads injected light. adds: terms that it adds to the sum. stores: another
    step, or a merge, reads what it makes."""

    first: bool = False
    adds: int = 0
    occluded: bool = False
    stores: bool = True

    @property
    def reads_injected(self) -> bool:
        return self.first or self.adds == 3


def steps_of(iterations: int, *, occluded: bool, keeps_last: bool) -> list[Step]:
    """The steps, of which each second one adds two terms, its own and the one before; S_0 is in the first of these."""
    if not iterations:
        return []
    begin = [Step(first=True, adds=2)] if iterations % 2 else [Step(first=True), Step(adds=3, occluded=occluded)]
    rest = [Step(occluded=occluded), Step(adds=2, occluded=occluded)]
    steps = begin + rest * ((iterations - len(begin)) // 2)
    return [*steps[:-1], steps[-1]._replace(stores=keeps_last)]


class _Faces:
    """What the geometry volume does to light, in thousandths (faces.wgsl).

    faces: words as the stored cells lie, three a cell: what its lower faces let through.
    reflectances: two words a cell, or a cell's channel, as light lies: what the blockers around it reflect of light
    along +x, +y, +z and along -x, -y, -z."""

    def __init__(self, device: Device, levels: Levels, bounces: str):
        self._threads = levels.dispatched(FACE_BLOCK, beyond=1)
        faces = device.buffer("LPV faces", size=levels.stored * 12)
        self.made = {"faces": faces}
        bindings = [storage("shares", "vec4f"), storage_rw("faces", "u32", "write")]
        if bounces != "none":
            size = levels.cells * 8 * (3 if bounces == "spectral" else 1)
            self.made["reflectances"] = device.buffer("LPV reflectances", size=size)
            bindings += [storage("reflectors", "vec4f"), storage_rw("reflectances", "vec2u", "write")]
        self._pass = ComputePass(
            device, "faces", "techniques/lpv/faces.wgsl", bindings, workgroup=(WORKGROUP, 1, 1),
            levels=levels.described(FACE_BLOCK, beyond=1), row=ROW, evaluation="", format="", access=[],
            bounces=bounces, block=FACE_BLOCK, block_cells=_places(FACE_BLOCK[:2]),
        )  # fmt: skip

    def run(self, stage: Any, volumes: dict[str, Any]) -> None:
        self._pass.run(stage, self._threads, **volumes, **self.made)


class Propagation:
    """`light` holds the accumulated light after `run`: vec4f [level][z][y][x][rgb], scaled for storage (cells.wgsl).

    sizes: cells along each side of the levels, all of which are propagated by the same dispatches; one is a uniform
    volume. Of a level of one cell all light leaves: it is not propagated.
    occlusion: the geometry volume dims what passes the cells' faces.
    bounces: with occlusion, "mono" or "spectral": blockers reflect what they take, grey or in their colour. Raises
    ValueError without.
    threshold: with one, `touched` becomes 1 where a level has been brought light (OLPV 4.2, the index volume): a
    contribution of more than that share of the power of two below the largest injected one.
    keeps_last: `last` holds the last step's light after `run`, which nothing but a merge by arrival asks for.
    """

    def __init__(
        self, device: Device, sizes: Sequence[int], *, evaluation: str, reprojection: str, gain: float,
        cell_format: str, threshold: float | None = None, occlusion: bool = False, bounces: str = "none",
        keeps_last: bool = False,
    ):  # fmt: skip
        if bounces not in BOUNCES or (bounces != "none" and not occlusion):
            raise ValueError(f"bounces are one of {', '.join(BOUNCES)}, and need occlusion; got '{bounces}'")
        self.levels, self._keeps_last = Levels(sizes), keeps_last
        self._travelled = Levels([n for n in sizes if n > 1])
        self._device, self.kind = device, CELL_TYPES[cell_format]
        size = self.levels.stored * CELL_BYTES[cell_format]
        self._cells = [device.buffer("LPV cells", size=size) for _ in range(2)]
        self.light = device.buffer("LPV accumulated light", size=self.levels.cells * 48)
        marks = threshold is not None
        self._marked: dict[str, Any] = {}
        if marks:
            self._marked = {"touched": device.buffer("LPV index volume", size=self.levels.cells * 4)}
        self._values = {
            "format": cell_format, "row": ROW, "marks": marks,
            "threshold": 8.0 * (threshold or 0.0),  # storage_scale.wgsl: the peak's power of two is 8
            **propagation_values(evaluation, reprojection, gain),
        }  # fmt: skip
        self._starts: dict[bool, ComputePass] = {}
        self._steps: dict[Step, ComputePass] = {}
        self._bounces = bounces
        self._faces = _Faces(device, self.levels, bounces) if occlusion else None
        self.last = self._cells[0]

    @property
    def values(self) -> dict[str, Any]:
        """What templates of cells.wgsl need to read `last`."""
        return {**self._values, "levels": self.levels.described(), "access": ["load"]}

    @property
    def blockers(self) -> dict[str, Any]:
        """What `run` has made of the geometry volume: "faces", and "reflectances" with bounces (faces.wgsl)."""
        return self._faces.made if self._faces else {}

    @property
    def touched(self) -> Any:
        """u32 [level][z][y][x]: 1 where the index volume's I_i is i."""
        return self._marked["touched"]

    def _start(self, stage: Any, resources: dict[str, Any], still: bool) -> None:
        """Injected light becomes the sum without a step: on all levels, or `still` on that of one cell alone."""
        if still not in self._starts:
            levels = self.levels.described()
            if still:
                levels = [{**levels[-1], "first": 0}]
            self._starts[still] = ComputePass(
                self._device, "start", "techniques/lpv/start.wgsl",
                [storage("injected", "vec4f"), storage("peak", "u32"), storage_rw("light", "vec4f", "write"),
                 storage_rw("cells_out", self.kind, "write"), *(storage_rw(name, "u32") for name in self._marked)],
                workgroup=(WORKGROUP, 1, 1), levels=levels, access=["store"], **self._values,
            )  # fmt: skip
        threads = (1,) if still else self.levels.dispatched()
        self._starts[still].run(
            stage, threads, **resources, light=self.light, cells_out=self._cells[0], **self._marked
        )

    def _step(self, step: Step) -> ComputePass:
        if step not in self._steps:
            sums = [storage_rw("light", "vec4f"), *(storage_rw(name, "u32") for name in self._marked)]
            self._steps[step] = ComputePass(
                self._device, "propagate", "techniques/lpv/propagation.wgsl",
                [*([] if step.first else [storage("cells_in", self.kind)]),
                 *([storage_rw("cells_out", self.kind, "write")] if step.stores else []),
                 *self._blockers(step), *(sums if step.adds else []),
                 *([storage("injected", "vec4f"), storage("peak", "u32")] if step.reads_injected else [])],
                workgroup=(WORKGROUP, 1, 1), block=BLOCK, first=step.first, adds=step.adds, sources=block_sources(),
                block_cells=_places(BLOCK), levels=self._travelled.described(BLOCK),
                access=["load"] * (not step.first) + ["store"] * step.stores, occluded=step.occluded, **block_faces(),
                bounces=self._bounces if step.occluded else "none", dither=0.5 * (step.adds > 0),
                **self._values,
            )  # fmt: skip
        return self._steps[step]

    def _blockers(self, step: Step) -> list[Binding]:
        kinds = {"faces": "u32", "reflectances": "vec2u"}
        return [storage(name, kinds[name]) for name in self.blockers] if step.occluded else []

    def run(
        self, stage: Any, injected: Any, peak: Any, iterations: int, shares: Any = None, reflectors: Any = None
    ) -> None:
        """Accumulate S_0 to S_k of `injected` (vec4f [level][z][y][x][rgb], W/sr) with k = `iterations`. shares: the
        geometry volume (vec4f [level][z][y][x]), half a cell aside, with `occlusion`; no step but the first goes
        without (CLPV 3.3). reflectors: three vec4f for each of its cells, with `bounces` (bounces.reflectors)."""
        light = {"injected": injected, "peak": peak}
        if not iterations or self.levels.sizes != self._travelled.sizes:
            self._start(stage, light, still=bool(iterations))
        if self._faces:
            volumes = {"shares": shares} | ({"reflectors": reflectors} if self._bounces != "none" else {})
            self._faces.run(stage, volumes)
        threads = self._travelled.dispatched(BLOCK)
        source, target = self._cells
        for step in steps_of(iterations, occluded=self._faces is not None, keeps_last=self._keeps_last):
            others: dict[str, Any] = {} if step.first else {"cells_in": source}
            if step.stores:
                others["cells_out"] = target
            if step.adds:
                others |= {"light": self.light, **self._marked}
            if step.occluded:
                others |= self.blockers
            if step.reads_injected:
                others |= light
            self._step(step).run(stage, threads, **others)
            source, target = target, source
        self.last = source
