"""How fast the injection is, against one atomic add for each VPL and coefficient in the same run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from octolux.frame.frame import Frame, FrameSettings
from octolux.frame.structs import VPL
from octolux.frame.vpl_sources import SOURCE, SourceGroup
from octolux.gpu.bindings import atomic_words, uniform
from octolux.gpu.device import Device
from octolux.gpu.passes import ComputePass
from octolux.gpu.records import read_records, record_texture, records
from octolux.renderer import Renderer
from octolux.scene.builtin import atrium
from octolux.scene.scene import Scene
from octolux.simulator.camera import pack_normals
from octolux.simulator.grid import Grid
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.lpv.constants import GRID, SH_CONSTANTS, pack_grid
from octolux.techniques.lpv.injection import Injection, VplSource
from octolux.techniques.settings import Settings

from .lab import device, interleaved, random_directions, read_buffer, submitted
from .registry import at_least, at_most, figure
from .scenes_on_disk import load

N, EDGE, PAIRS = 32, 512, 41
COUNT = EDGE**2  # 262,144 VPLs: an RSM of EDGE x EDGE
_ATOMICS = Path(__file__).parent / "baselines" / "injection_atomics.wgsl"
_GRID = Grid((0.0, 0.0, 0.0), 1.0, N)
Case = tuple[np.ndarray, list[VplSource], Grid]


class OneAddEach(Injection):
    """The baseline: a thread and twelve atomic adds for each VPL; each light has a scale, and so a turn, of its own."""

    def __init__(self, device: Device, n: int) -> None:
        super().__init__(device, n)
        self._inject = ComputePass(
            device, "one add each", str(_ATOMICS),
            [uniform("source", SOURCE), uniform("grid", GRID), records("vpls", VPL), atomic_words("sums", "i32")],
            structs=[SOURCE, GRID, VPL], workgroup=(64, 1, 1), **SH_CONSTANTS,
        )  # fmt: skip

    def run(self, stage: Any, grid: Any, vpls: Any, sources: Sequence[VplSource]) -> None:
        stage.encoder.clear_buffer(self.injected)
        stage.encoder.clear_buffer(self.peak)
        for number, source in enumerate(sources):
            buffer = self._source_buffer(number, SourceGroup([source], *SourceGroup.bounds(source)).pack()[0])
            self._inject.run(stage, (source.count,), source=buffer, grid=grid, vpls=vpls, sums=self._sums)
            self._collect.run(
                stage, (self.n**3,), source=buffer, sums=self._sums, injected=self.injected, peak=self.peak
            )


class _OnlyVpls(NoTechnique):
    """Lets the renderer make RSMs, and keeps the frame."""

    needs = frozenset({"rsm"})
    frame: Frame

    def update(self, frame: Frame) -> None:
        self.frame = frame


def scene_vpls(scene: Scene, settings: FrameSettings) -> Case:
    """The VPLs of all lights of a scene, as the frame has them, and the default volume around it."""
    renderer = Renderer(scene, "none", size=(8, 8), device=device(), frame_settings=settings)
    technique = _OnlyVpls(device(), Settings())
    renderer.technique = technique
    renderer.render()
    frame = technique.frame
    lights = zip(frame.vpl_ranges, frame.vpl_widths, frame.lights.total_flux, strict=True)
    sources = [VplSource(first, count, flux, width=width) for (first, count), width, flux in lights]
    vpls = read_records(device(), frame.vpls, VPL, sum(count for _, count in frame.vpl_ranges))
    return vpls, sources, Grid.around(*frame.world_box, N)


def sun_vpls(scene: Scene) -> Case:
    """The COUNT VPLs of a scene's first light, a sun, whose map is EDGE across."""
    settings = FrameSettings(shadow_resolution=2 * EDGE, rsm_resolution=EDGE, sky_lights=0)
    vpls, sources, grid = scene_vpls(scene, settings)
    return vpls, sources[:1], grid


def made_up(positions: np.ndarray, normals: np.ndarray) -> Case:
    """VPLs at `positions` in a volume of unit cells, with random flux."""
    vpls = VPL.array(COUNT)
    vpls["position"], vpls["normal"] = positions, pack_normals(normals)
    vpls["flux"] = np.random.default_rng(0).uniform(0.1, 1.0, (COUNT, 3))
    return vpls, [VplSource(0, COUNT, np.full(3, float(COUNT)), width=EDGE)], _GRID


def one_wall() -> Case:
    """A wall across the volume, seen straight on."""
    across = 1.0 + (N - 2.0) * (np.arange(EDGE) + 0.5) / EDGE
    u, v = np.meshgrid(across, across)
    return made_up(np.stack([u, np.full_like(u, 5.0), v], axis=-1).reshape(-1, 3), np.array([0.0, 1.0, 0.0]))


def scattered() -> Case:
    """Anywhere, facing anywhere: neighbours in the map have nothing in common."""
    rng = np.random.default_rng(1)
    return made_up(rng.uniform(1.0, N - 1.0, (COUNT, 3)), random_directions(rng, COUNT))


@cache
def _made() -> tuple[OneAddEach, Injection]:
    return OneAddEach(device(), N), Injection(device(), N)


def _speedup(case: Case) -> float:
    """Ratio of times of the whole injection: clearing, scattering, to W/sr."""
    vpls, sources, grid = case
    buffers = device().uniform("grid", pack_grid(grid)), record_texture(device(), "VPLs", VPL, len(vpls), vpls)

    def timed(made: Injection) -> None:
        with submitted() as stage:
            made.run(stage, *buffers, sources)

    baseline, ours = _made()
    return interleaved(lambda: timed(baseline), lambda: timed(ours), PAIRS)["ratio"]


def different_words(case: Case) -> int:
    """How many words of the injected light and its peak differ from the baseline's."""
    vpls, sources, grid = case
    buffers = device().uniform("grid", pack_grid(grid)), record_texture(device(), "VPLs", VPL, len(vpls), vpls)
    found = []
    for made in _made():
        with submitted() as stage:
            made.run(stage, *buffers, sources)
        found.append(np.append(read_buffer(made.injected, np.uint32), read_buffer(made.peak, np.uint32)))
    assert found[0].any()
    return int(np.count_nonzero(found[0] != found[1]))


@figure("injection_speedup", group="ratios", unit="x", bound=dict.fromkeys(("wall", "atrium"), at_least(2.0)))
def injection_speedup() -> dict[str, float]:
    """262,144 VPLs of one light into 32^3 cells, against one atomic add for each coefficient of each VPL.

    Scattered VPLs share no cells with their neighbours: nothing can be added up first, and looking for it costs.
    """
    return {
        "wall": _speedup(one_wall()), "atrium": _speedup(sun_vpls(atrium())), "scattered": _speedup(scattered()),
    }  # fmt: skip


@figure("injection_speedup_crytek", group="ratios", unit="x", bound=at_least(2.0))
def injection_speedup_crytek() -> float:
    """The same for the sun of Crytek Sponza."""
    return _speedup(sun_vpls(load("crytek_sponza")))


@figure("injection_speedup_sky", group="ratios", unit="x", bound=at_least(2.0))
def injection_speedup_sky() -> float:
    """The same for the atrium as it is by default, a sun and 32 lights of the sky: the baseline's lights take turns."""
    return _speedup(scene_vpls(atrium(), FrameSettings()))


@figure("injection_baseline", group="kernels", unit="words", bound=at_most(0))
def injection_baseline() -> int:
    """Words of the injected light and its peak that differ from the baseline's: of a sun, a wall, scattered VPLs."""
    return sum(different_words(case) for case in (sun_vpls(atrium()), one_wall(), scattered()))
