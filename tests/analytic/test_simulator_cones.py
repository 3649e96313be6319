"""Cones through the geometry volume (simulator/lpv/cones.py): what walls stop, wherever they lie, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from test_simulator_geometry import N
from test_simulator_planes import PLACE, wall

from octolux.simulator.lpv import geometry
from octolux.simulator.lpv.cones import CONE_LENGTH, FADE, SHORT, WHOLE, cone_transmittance
from octolux.simulator.lpv.strips import Planes, pack_planes, unpack_planes


class Ways:
    """Random ones from the middles of cells to anywhere, in nodes of a size that suits the way: as large as may be of
    those that are 1.5 sizes away at least (gathering.takes)."""

    def __init__(self, seed: int, n: int, count: int = 3000, rim: int = 0):
        rng = np.random.default_rng(seed)
        self.start, self.end = rng.integers(rim, n - rim, (count, 3)) + 0.5, rng.uniform(0.0, n, (count, 3))
        away = np.abs(self.end - self.start).max(axis=-1)
        self.size = 2.0 ** np.floor(np.log2(np.maximum(away / 1.5, 1.0)))
        self.away = away
        # Euclidean length is at most sqrt(3) of what is travelled, and CONE_LENGTH cells at least.
        self.widest = 2.0 ** np.floor(np.log2(np.maximum(away * np.sqrt(3.0) / CONE_LENGTH, 1.0)))

    def transmittance(self, levels: list[Planes]) -> np.ndarray:
        return cone_transmittance(levels, self.start, self.end, self.size)

    def crosses(self, axis: int, place: float) -> np.ndarray:
        """Where a march must meet the plane: from another layer of cells than the start's, which is left out, and
        before the last step, which is as long as the coarsest cells are wide."""
        a, b = self.start[:, axis], self.end[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            travelled = self.away * np.abs((place - a) / (b - a))
        last = self.away - 0.5 * self.size - 0.25
        between = ((a < place) != (b < place)) & (np.floor(a) != np.floor(place))
        return between & (travelled > 0.5) & (travelled < last - self.widest)

    def beside(self, axis: int, place: float, slack: float) -> np.ndarray:
        """What lies on one side, by more than `slack` of the coarsest cells."""
        a, b = self.start[:, axis], self.end[:, axis]
        return ((a < place) == (b < place)) & (np.minimum(abs(a - place), abs(b - place)) > slack * self.widest)


def test_the_empty_volume_lets_everything_pass():
    nothing = Planes.sheets(np.zeros((N, N, N, 3)), np.random.default_rng(1).random((N, N, N, 3)))
    assert (Ways(0, N).transmittance(geometry.plane_levels(nothing)) == 1.0).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("n", [16, 64])
def test_a_wall_stops_what_crosses_it_and_nothing_else(axis, n):
    """Wherever it lies in its cells, at every slant, and on every level that the march goes through."""
    ways, stopped, free = Ways(2, n), 0, 0
    for place in (0.21 * n, 0.5 * n, 0.5 * n - 0.01, 0.77 * n):
        found = ways.transmittance(wall(axis, place, n=n))
        crosses, beside = ways.crosses(axis, place), ways.beside(axis, place, 0.0)
        assert np.all(found[crosses] == 0.0) and np.all(found[beside] == 1.0), place
        stopped, free = stopped + crosses.sum(), free + beside.sum()
    assert stopped > 1000 and free > 1000


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_packed_wall_does_too(axis):
    """But for what ends nearer to it than packing moves a plane, in the coarsest cells in use. Where the march goes on
    to a coarser level, a plane may be moved from beyond to before the end of the former's steps. They overlap by half
    a step of the coarser level at least, if not by all of the cell, so that a way would have to run along the wall, by
    less than 1/16 of what it goes ahead."""
    ways = Ways(4, 64)
    slope = np.abs(ways.end - ways.start)[:, axis] / ways.away
    for place in (13.44, 31.99, 49.28):
        levels = wall(axis, place, n=64)
        words = [pack_planes(level) for level in levels]
        found = ways.transmittance([unpack_planes(w) for w in words])
        near = np.minimum(*(np.abs(x[:, axis] - place) for x in (ways.start, ways.end))) <= PLACE * ways.widest
        crosses = ways.crosses(axis, place) & ~near & (slope > 1 / 16)
        assert np.all(found[crosses] == 0.0) and crosses.sum() > 200
        assert np.all(found[ways.beside(axis, place, PLACE)] == 1.0)


def test_a_half_open_wall_lets_half_pass():
    """Exactly, on level 0: each way crosses it once, whatever its slant. Where a way goes on to another level it may
    count on both."""
    ways = Ways(5, N, 20000)
    short = ways.away < 2.0 * CONE_LENGTH / np.sqrt(3.0)  # a way is up to sqrt(3) times as long as what it travels
    for place in (5.3, 8.0, 10.9):
        found, crosses = ways.transmittance(wall(1, place, 0.5)), ways.crosses(1, place)
        assert np.all(found[crosses & short] == 0.5) and np.count_nonzero(crosses & short) > 5
        assert set(found[crosses]) == {0.5, 0.25} and np.mean(found[crosses] == 0.5) > 0.7


def test_shares_are_what_passes_on_average():
    """Planes anywhere in their cells: of a way that goes 1/4 of a cell along an axis in each of seven steps,
    (1 - s / 4)^7 passes on average, as if a share s blocked by a.|u| (the top of geometry.py)."""
    rng, share, found = np.random.default_rng(6), 0.6, []
    start = np.array([[1.5, 2.5, z + 0.5] for z in range(N)])
    end = start + np.array([8.0, 2.0, 0.0])
    for _ in range(300):
        shares, offsets = np.zeros((N, N, N, 3)), rng.random((N, N, N, 3))
        shares[..., 1] = share
        found.append(cone_transmittance([Planes.sheets(shares, offsets)], start, end, 1.0))
    expected = (1.0 - share / 4.0) ** 7
    assert abs(np.mean(found) - expected) < 4.0 * np.std(found) / np.sqrt(np.size(found))


def test_ways_in_a_room_are_not_dimmed():
    """From the middles of cells whose walls lie in them to anywhere: along walls, into edges and into corners. Not with
    shares alone, of which each cell at a wall has one."""
    low, high = np.array([1.3, 2.25, 1.4]), np.array([13.7, 14.9, 13.6])
    shares, offsets = np.zeros((2, N, N, N, 3))
    for axis in range(3):
        for place in (low[axis], high[axis]):
            np.moveaxis(shares, 2 - axis, 0)[int(place), ..., axis] = 1.0
            np.moveaxis(offsets, 2 - axis, 0)[int(place), ..., axis] = place % 1.0
    ways = Ways(7, N, 20000)
    ways.end = low + (high - low) * np.random.default_rng(8).random(ways.end.shape)
    inside = np.all((ways.start > low) & (ways.start < high), axis=-1)
    assert np.all(ways.transmittance(geometry.plane_levels(Planes.sheets(shares, offsets)))[inside] == 1.0)
    touching = inside & np.any((ways.start < low + 1.0) | (ways.start > high - 1.0), axis=-1)
    assert touching.sum() > 1000


@pytest.mark.parametrize("sense", [1, -1])
def test_the_start_and_the_node_are_left_out(sense):
    """Straight ways: none of the start's cell and the end's, and half of a larger node, as far as it goes on."""
    start, end = np.full((1, 3), 20.5), np.full((1, 3), 20.5)
    end[0, 1] += sense * 9.0
    for layer in range(32):
        levels, ahead = wall(1, layer + 0.5, n=32), sense * (layer - 20)
        for size, room, left_out in ((1.0, 9.0, 1), (4.0, 9.0, 2), (8.0, 9.0, 4), (8.0, 2.5, 3), (8.0, 0.5, 1)):
            blocked = 0 < ahead < 9 - left_out + 1
            found = cone_transmittance(levels, start, end, size, room=room)
            assert found == (0.0 if blocked else 1.0), (layer, size, room)


@pytest.mark.parametrize("narrower", [1, 2])
def test_a_narrower_cone_stays_on_a_level_for_longer(narrower):
    """A straight way through half-open layers that the finest level alone has: the steps before the one that is twice
    as long as the cone of cells half as wide meet one each."""
    middles = np.full((64, 64, 64, 3), 0.5)
    levels = [Planes.sheets(middles, middles), Planes.sheets(np.zeros((32, 32, 32, 3)), middles[::2, ::2, ::2])]
    start, way = np.full((1, 3), 8.5), np.array([0.0, 0.0, 50.0])
    found = cone_transmittance(levels, start, start + way, 1.0, cone_length=narrower * CONE_LENGTH)
    assert found == 0.5 ** (2.0 * CONE_LENGTH * narrower - 1.0)


def test_mirrored_ways_pass_as_much():
    """A random volume and its mirror image, for ways of all directions and levels: no axis and no sense is special but
    for ties, which random volumes do not forgive."""
    rng = np.random.default_rng(3)
    shares, offsets = rng.uniform(0.0, 0.4, (N, N, N, 3)), rng.random((N, N, N, 3))
    cells = rng.integers(0, N, (2, 300, 3))
    size = 2.0 ** rng.integers(0, 3, 300)

    def passed(shares, offsets, ends):
        return cone_transmittance(geometry.plane_levels(Planes.sheets(shares, offsets)), *ends, size)

    straight = passed(shares, offsets, cells + 0.5)
    mirrored = passed(shares[::-1, ::-1, ::-1], 1.0 - offsets[::-1, ::-1, ::-1], N - 0.5 - cells)
    np.testing.assert_allclose(mirrored, straight, rtol=1e-12)
    turned = (np.moveaxis(a, (0, 1, 2), (1, 2, 0))[..., [1, 2, 0]] for a in (shares, offsets))
    cycled = passed(*turned, cells[..., [1, 2, 0]] + 0.5)
    assert np.isclose(cycled, straight, rtol=1e-12).mean() > 0.9  # ties of the longest axis go to the first
    assert 0.01 < np.median(straight) < 0.99


EMPTY = geometry.plane_levels(Planes.sheets(np.zeros((32, 32, 32, 3)), np.zeros((32, 32, 32, 3))))


def test_a_way_leaves_a_level_at_its_ends():
    """From 10.5 to an end at 20.3 the way's steps go to cells 16 and 17, and to cells 18 and 19, at whose last the end
    is 0.8 cells away: they count by that over FADE, and the next level's step to the former by the rest. Its step to
    the latter is made, and those beyond. So a wall stays closed that both levels have, and one of them shows as much
    of it as that."""
    start, end = np.array([[10.5, 16.5, 16.5]]), np.array([[30.5, 16.5, 16.5]])
    ends, share = np.array([[[0.0] * 3, [20.3, 32.0, 32.0]], *[WHOLE] * 5]), (9.8 / SHORT - 9.0) / FADE
    for place, fine, coarse in ((11.2, 0.0, 1.0), (15.9, 0.0, 1.0), (17.9, 0.0, share), (18.2, 1.0 - share, 0.0),
                                (19.8, 1.0 - share, 0.0), (20.1, 1.0, 0.0), (23.5, 1.0, 0.0)):  # fmt: skip
        both, at = wall(0, place, n=32), (start, end, 4.0, None, ends)
        np.testing.assert_allclose(cone_transmittance([both[0], *EMPTY[1:]], *at), fine, atol=1e-12)
        np.testing.assert_allclose(cone_transmittance([EMPTY[0], *both[1:]], *at), coarse, atol=1e-12)
        assert cone_transmittance(both, *at) == 0.0, place


def nested_ends(low, high, count: int = 3) -> list[np.ndarray]:
    """Of so many levels: of the first from `low` to `high`, and of each FADE of the next level's cells away from it."""
    ends = [np.array([low, high])]
    while len(ends) < count:
        ends.append(0.5 * ends[-1] + np.array([[-FADE], [FADE]]))
    return ends


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_wall_stops_what_crosses_it_wherever_levels_end(axis):
    """And nothing else."""
    n, ways, stopped, free = 64, Ways(10, 64, 20000), 0, 0
    rng = np.random.default_rng(11)
    for place in (13.44, 30.7, 31.3, 40.2):
        ends = nested_ends(rng.uniform(12.0, 24.0, 3), rng.uniform(40.0, 52.0, 3))
        inside = np.all((ways.start > ends[0][0]) & (ways.start < ends[0][1]), axis=-1)
        where = np.array([*ends, *[WHOLE] * 4])
        found = cone_transmittance(wall(axis, place, n=n), ways.start, ways.end, ways.size, None, where)
        crosses, beside = inside & ways.crosses(axis, place), inside & ways.beside(axis, place, 0.0)
        assert np.all(found[crosses] == 0.0) and np.all(found[beside] == 1.0), place
        stopped, free = stopped + crosses.sum(), free + beside.sum()
    assert stopped > 1000 and free > 1000


def random_window(rng: np.random.Generator, n: int) -> Planes:
    return Planes.sheets(rng.uniform(0.0, 0.4, (n, n, n, 3)), rng.random((n, n, n, 3)))


def test_ways_do_not_depend_on_which_cells_a_window_has():
    """The same surfaces in two windows that share their ends, though one begins some cells farther on: to the bit."""
    rng = np.random.default_rng(9)
    fine, coarser = random_window(rng, 32), geometry.plane_levels(random_window(rng, 16))
    ends = np.array([[[8.7, 6.3, 12.2], [21.4, 19.6, 27.1]], *[WHOLE] * 5])
    start, end = rng.integers((8, 6, 12), (22, 20, 28), (500, 3)) + 0.5, rng.uniform(0.0, 32.0, (500, 3))
    size, found = 2.0 ** rng.integers(0, 3, 500), []
    for x, y, z in ((8, 4, 12), (6, 6, 12)):
        window = Planes(*(a[z : z + 16, y : y + 16, x : x + 16] for a in fine))
        origins = np.array([(x, y, z), *[(0, 0, 0)] * 5])
        found.append(cone_transmittance([window, *coarser], start, end, size, origins, ends))
    np.testing.assert_array_equal(*found)
    assert 0.01 < np.median(found[0]) < 0.99


def leaves(ways: Ways, ends: list[np.ndarray]) -> np.ndarray:
    """Where ways leave each level, (levels, M), in its cells along their longest components: where they go through its
    ends, or FADE cells after they are too wide."""
    way, found = ways.end - ways.start, []
    for level, (low, high) in enumerate(ends):
        room = (np.where(way > 0.0, high, low) - ways.start / 2.0**level) / (SHORT * way) * ways.away[:, None]
        long_enough = 2.0 * CONE_LENGTH * ways.away / np.linalg.norm(way, axis=-1) + FADE
        found.append(np.minimum(long_enough, room.min(axis=-1)))
    return np.array(found)


def test_what_passes_changes_smoothly_when_ends_move():
    """Of a level one pair of steps at most gives way at a time (FADE is the length of a pair), by as much as the place
    where the way leaves the level is moved, over FADE; all else that is multiplied is at most 1, and so is the
    difference between the pair and what it gives way to. So what passes changes by the sum of that over all levels,
    whatever they hold: these have nothing in common."""
    rng, ways, before, most = np.random.default_rng(12), Ways(13, 64, 400, rim=20), None, 0.0
    levels = [random_window(rng, n) for n in (64, 32, 16)] + geometry.plane_levels(random_window(rng, 8))
    for moved in np.linspace(0.0, 6.0, 600):
        ends = nested_ends(19.7 - moved * np.array([1.0, 0.3, 0.7]), 44.6 + moved * np.array([0.2, 0.9, 1.0]))
        where = np.array([*ends, *[WHOLE] * 4])
        found = cone_transmittance(levels, ways.start, ways.end, ways.size, None, where), leaves(ways, ends)
        if before is not None:
            change, allowed = np.abs(found[0] - before[0]), np.abs(found[1] - before[1]).sum(axis=0) / FADE
            assert np.all(change <= allowed + 1e-9)
            most = max(most, (change / np.maximum(allowed, 1e-9)).max())
        before = found
    assert most > 0.1


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_what_one_level_alone_holds_comes_and_goes_smoothly(sense):
    """A wall that only the fine level has is behind its end at first, and then before it: without anything between,
    the light would be there in one frame and gone in the next. While the end goes a cell, a FADE of it does."""
    start, end = np.full((1, 3), 24.5), np.full((1, 3), 24.5)
    end[0, 1] += sense * 20.0
    nothing = Planes.sheets(np.zeros((64, 64, 64, 3)), np.zeros((64, 64, 64, 3)))
    levels, found, step = [wall(1, 24.5 + sense * 6.2, n=64)[0], *geometry.plane_levels(nothing)[1:]], [], 0.05
    for away in np.arange(2.0, 10.0, step):
        ends = np.array([[[24.5 - away] * 3, [24.5 + away] * 3], *[WHOLE] * 6])
        found.append(cone_transmittance(levels, start, end, 4.0, None, ends)[0])
    changes = np.diff(found)
    assert found[0] == 1.0 and found[-1] == 0.0 and np.all(changes <= 0.0)
    assert np.abs(changes).max() <= step / (SHORT * FADE) + 1e-9
