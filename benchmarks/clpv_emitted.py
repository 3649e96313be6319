"""Low-frequency direct light in volumes (CLPV 3.1): whether all is injected, how long it takes, what it lights."""

from __future__ import annotations

import statistics
from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np

from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, Light, ParticleLights
from octolux.scene.scene import Scene
from octolux.simulator import direct
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import gathering
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.emitted import EmittedInjection, EmittedLights

from .lab import device, milliseconds, read_buffer, submitted
from .registry import aim, figure, within

N, CELL = 32, 0.25
WHOLE = Grid((-4.0, -4.0, -4.0), CELL, N)
NESTED = [Grid((-h * N / 2,) * 3, h, N) for h in (CELL, 2 * CELL, 4 * CELL)]
COLOR = np.array([1.0, 2.0, 3.0])
PARTICLES, RUNS = 10_000, 31
HEIGHT = 3.1
"""Of the square light, in metres: in no particular place between the faces of cells."""
SQUARE = AreaLight(
    corners=((-1.0, HEIGHT, -1.0), (1.0, HEIGHT, -1.0), (1.0, HEIGHT, 1.0), (-1.0, HEIGHT, 1.0)), radiance=tuple(COLOR)
)
UP, DOWN, ASIDE = 2, 3, 0
"""Numbers of faces, by their normals in the order of `transfer.DIRECTIONS`."""


class Volume:
    """Nested volumes on the device, into which the low-frequency light of a scene goes."""

    def __init__(self, grids: list[Grid], lights: list[Light], environment: Environment | None = None):
        self.grids = grids
        self.emitted, self.injection = EmittedLights(device()), EmittedInjection(device(), N, grids=len(grids))
        scene = Scene(lights=lights, environment=environment or Environment())
        frame: Any = SimpleNamespace(
            scene=scene, surroundings=scene.environment, gpu_scene=SimpleNamespace(moves=0)
        )  # what of a frame they ask for
        self.emitted.sync(frame, grids)
        self._grids = device().uniform("grids", pack_grids(grids))
        self._injected = device().buffer("injected", size=len(grids) * N**3 * 48)
        self._peak = device().buffer("peak", size=4)

    def inject(self) -> None:
        """Into dark cells, and wait."""
        with submitted() as stage:
            stage.encoder.clear_buffer(self._injected)
            stage.encoder.clear_buffer(self._peak)
            self.injection.run(stage, self._grids, self.emitted, self._injected, self._peak)
        device().wait()

    def cells(self) -> np.ndarray:
        """[grid][z][y][x][rgb][4], float64, W/sr."""
        self.inject()
        return read_buffer(self._injected).reshape(len(self.grids), N, N, N, 3, 4).astype(np.float64)


def swarm() -> ParticleLights:
    """PARTICLES of many strengths in all of the nested volumes."""
    rng = np.random.default_rng(1)
    intensities = rng.random((PARTICLES, 3)) ** 2 * COLOR
    return ParticleLights(positions=rng.uniform(-15.9, 15.9, (PARTICLES, 3)), intensities=intensities)


def sky() -> Environment:
    """Radiance COLOR above the horizon, none below."""
    image = np.zeros((128, 256, 3), np.float32)
    image[:64] = COLOR
    return Environment(image=image)


def _flux(lights: list[Light], environment: Environment | None, expected: list[np.ndarray]) -> float:
    """Injected over expected, the volume and channel that is off most; infinite where light is that should not be.
    expected: of each volume, which has all light that lies in it."""
    found = [total_flux(cells) for cells in Volume(NESTED, lights, environment).cells()]
    pairs = zip(found, expected, strict=True)
    ratios = [np.divide(f, e, out=np.where(f > 0.0, np.inf, 1.0), where=e > 0.0) for f, e in pairs]
    return float(max(np.ravel(ratios), key=lambda ratio: abs(ratio - 1.0)))


def _of_particles(group: ParticleLights) -> list[np.ndarray]:
    """4 pi I of those in each volume."""
    held = (np.abs(group.positions).max(axis=-1) < 0.5 * N * grid.cell_size for grid in NESTED)
    return [4.0 * pi * group.intensities[each].sum(axis=0) for each in held]


@figure("emitted_flux", group="clpv_emitted", unit="x", bound=dict.fromkeys(
    ("particles", "square", "even_sky", "sky_above_horizon"), within(1.0, 0.01)))  # fmt: skip
def emitted_flux() -> dict[str, float]:
    """Flux in each of three nested volumes over the closed form: 4 pi I of what lies in it; pi L A; and in the last,
    which alone has a sky, pi L for each m^2 of its faces, of whose sides a sky that ends at the horizon lights half,
    and of whose bottom none."""
    group, face, none = swarm(), (4 * CELL * N) ** 2, [np.zeros(3)] * 2
    return {
        "particles": _flux([group], None, _of_particles(group)),
        "square": _flux([SQUARE], None, [pi * COLOR * 4.0] * 3),
        "even_sky": _flux([], Environment(tuple(COLOR)), [*none, 6.0 * face * pi * COLOR]),
        "sky_above_horizon": _flux([], sky(), [*none, 3.0 * face * pi * COLOR]),
    }


@figure("emitted_time", group="clpv_emitted", unit="ms")
def emitted_time() -> dict[str, float]:
    """Injection into three volumes of 32^3 cells, with clearing them: 10,000 particles, a square light, a sky; and the
    clearing alone. Medians of runs in turn."""
    cases = {
        "particles": Volume(NESTED, [swarm()]), "square": Volume(NESTED, [SQUARE]),
        "sky": Volume(NESTED, [], sky()), "nothing": Volume(NESTED, []),
    }  # fmt: skip
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(RUNS + 3):
        for name, volume in cases.items():
            times[name].append(milliseconds(volume.inject))
    return {name: statistics.median(each[3:]) for name, each in times.items()}


def gathered(volume: Volume, cells: list[list[int]], face: int) -> np.ndarray:
    """Irradiance (M, 3) on a face of cells (x, y, z), gathered from the injected light in float64."""
    nodes = gathering.light_nodes(volume.cells()[0])
    return gathering.gather(np.array(cells), nodes, CELL)[:, face]


@figure("emitted_square", group="clpv_emitted", unit="x", bound=dict.fromkeys(
    ("below_0.7m", "below_1.0m", "below_2.0m", "below_4.0m", "below_6.5m", "aside_2.0m"), aim("1")))  # fmt: skip
def emitted_square() -> dict[str, float]:
    """Irradiance under a square light of 2 m x 2 m, gathered, over the closed form; aside: below its edge."""
    rows = {"below_0.7m": (16, 25), "below_1.0m": (16, 24), "below_2.0m": (16, 20), "below_4.0m": (16, 12),
            "below_6.5m": (16, 2), "aside_2.0m": (20, 20)}  # fmt: skip
    cells = [[x, y, 16] for x, y in rows.values()]
    points = np.array(WHOLE.origin) + (np.array(cells) + 0.5) * CELL
    expected = direct.irradiance(SQUARE, points, np.array([0.0, 1.0, 0.0]))
    ratios = gathered(Volume([WHOLE], [SQUARE]), cells, UP) / expected
    return dict(zip(rows, ratios.mean(axis=1).tolist(), strict=True))


@figure("emitted_sky", group="clpv_emitted", unit="x", bound={
    **dict.fromkeys(("even_middle", "even_1m", "even_0.4m", "even_aside"), aim("1")),
    **dict.fromkeys(("sky_middle_up", "sky_1m_up", "sky_middle_aside"), aim("1")), "sky_middle_down": aim("0"),
})  # fmt: skip
def emitted_sky() -> dict[str, float]:
    """Irradiance in the open, gathered, over the closed form pi L (aside: pi L / 2 where the sky ends at the horizon;
    down: over pi L), in the middle of 8 m and nearer to the lower border.

    A face's light is held as one cosine lobe at most: of a sky that ends at the horizon some of what enters at the
    sides is then sent upwards.
    """
    cells = [[16, 16, 16], [16, 4, 16], [16, 1, 16]]
    even, half = Volume([WHOLE], [], Environment(tuple(COLOR))), Volume([WHOLE], [], sky())
    levels = (gathered(even, cells, UP) / (pi * COLOR)).mean(axis=1)
    above = (gathered(half, cells, UP) / (pi * COLOR)).mean(axis=1)
    return {
        "even_middle": levels[0], "even_1m": levels[1], "even_0.4m": levels[2],
        "even_aside": (gathered(even, cells, ASIDE)[0] / (pi * COLOR)).mean(),
        "sky_middle_up": above[0], "sky_1m_up": above[1],
        "sky_middle_aside": (gathered(half, cells, ASIDE)[0] / (0.5 * pi * COLOR)).mean(),
        "sky_middle_down": (gathered(half, cells, DOWN)[0] / (pi * COLOR)).mean(),
    }  # fmt: skip
