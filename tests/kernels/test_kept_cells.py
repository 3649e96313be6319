"""Cells that keep static surfaces from frame to frame on the device, against the simulator's; what moves is not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_octree_geometry import GRID, LEVELS, N, random_surfels, surfels_of

from octolux.frame import traits
from octolux.frame.structs import VPL
from octolux.gpu.records import record_texture, word_texture
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import geometry
from octolux.simulator.lpv.keeping import forgotten_cells, shifted, window_shift
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.geometry import GeometryVolume, fixed_point_wall
from octolux.techniques.lpv.keeping import KeptCells
from octolux.techniques.lpv.levels import Levels

WINDOWS = [Grid((-1.0, -0.5, 2.0), 0.25, N), Grid((-2.0, -2.5, 0.5), 0.5, N), Grid((-5.5, -5.0, -4.0), 1.0, N)]
NOTHING = np.zeros((2, 0, 3))


class History:
    """What a GpuScene tells of what static things have left."""

    def __init__(self) -> None:
        self.static_version, self.left_boxes = 0, NOTHING

    def leave(self, boxes: np.ndarray, versions: int = 1) -> None:
        self.static_version, self.left_boxes = self.static_version + versions, boxes


def moved(grid: Grid, *cells: int) -> Grid:
    x, y, z = np.add(grid.origin, grid.cell_size * np.array(cells)).tolist()
    return Grid((x, y, z), grid.cell_size, grid.n)


@pytest.fixture
def kept(device) -> SimpleNamespace:
    """Cells full of random numbers, of one and of three vec4f, in three windows."""
    made, history = KeptCells(device, Levels([N] * 3, 3), {"a": 1, "b": 3}, 0.5), History()
    rng, contents = np.random.default_rng(1), {}
    with one_stage(device) as stage:
        made.follow(stage, WINDOWS, history)
    for name, count in (("a", 1), ("b", 3)):
        contents[name] = rng.random((3, N, N, N, 4 * count), np.float32)
        device.write(made.volume[name], contents[name])
    return SimpleNamespace(made=made, history=history, contents=contents)


def follow(device, kept: SimpleNamespace, grids: list[Grid]) -> dict[str, np.ndarray]:
    with one_stage(device) as stage:
        kept.made.follow(stage, grids, kept.history)
    shapes = {name: contents.shape for name, contents in kept.contents.items()}
    return {name: read_buffer(device, kept.made.volume[name]).reshape(shape) for name, shape in shapes.items()}


SHIFTS = [[(4, 0, 0), (0, -4, 0), (0, 0, 0)], [(-8, 4, 12), (0, 0, 0), (0, 0, 0)], [(N, 0, 0), (0, -N, 3), (1, 2, -30)]]


@pytest.mark.parametrize("shifts", SHIFTS, ids=["one axis", "all axes", "beyond"])
def test_contents_stay_in_the_world_to_the_bit(device, kept, shifts):
    """And back again: what has left is gone."""
    there = [moved(grid, *shift) for grid, shift in zip(WINDOWS, shifts, strict=True)]
    found = follow(device, kept, there)
    expected = {
        name: [shifted(a, s) for a, s in zip(each, shifts, strict=True)] for name, each in kept.contents.items()
    }
    assert all(np.array_equal(found[name], expected[name]) for name in found)
    back = follow(device, kept, WINDOWS)
    for name, contents in expected.items():
        again = [shifted(a, tuple(-c for c in s)) for a, s in zip(contents, shifts, strict=True)]
        assert np.array_equal(back[name], again) and back[name].any() == (N not in shifts[0])


def test_what_was_left_is_emptied(device, kept):
    """In all windows, once; also in a frame in which they move."""
    rng = np.random.default_rng(2)
    middles = rng.uniform(-2, 4, (5, 3))
    boxes, half = np.stack([middles, middles]), rng.uniform(0.0, 0.8, (5, 3))
    boxes += np.stack([-half, half])
    for shift in ((0, 0, 0), (4, -4, 0)):
        there = [moved(grid, *shift) for grid in WINDOWS]
        kept.history.leave(boxes)
        found = follow(device, kept, there)
        for number, grid in enumerate(there):
            empty = forgotten_cells(grid, *boxes, 0.5)
            for name, contents in kept.contents.items():
                contents[number] = np.where(empty[..., None], 0.0, shifted(contents[number], shift))
                assert np.array_equal(found[name][number], contents[number])
            assert 0.0 < empty.mean() < 0.9
    kept.history.leave(NOTHING)  # something has appeared
    again = follow(device, kept, there)
    assert all(np.array_equal(again[name], found[name]) for name in found)


@pytest.mark.parametrize("what", ["lattice", "size", "scene", "missed", "forget"])
def test_all_is_emptied(device, kept, what):
    """When cells are others, or some change was not seen."""
    grids = list(WINDOWS)
    if what == "lattice":
        grids[1] = moved(grids[1], 0.5, 0, 0)
    elif what == "size":
        grids = [Grid(grid.origin, 1.5 * grid.cell_size, N) for grid in grids]
    elif what == "scene":
        kept.history = History()
    elif what == "missed":
        kept.history.leave(NOTHING, versions=2)
    else:
        kept.made.forget()
    assert not any(contents.any() for contents in follow(device, kept, grids).values())


def test_nothing_is_done_while_nothing_changes(device, kept):
    before = dict(kept.made.volume)
    found = follow(device, kept, WINDOWS)
    assert kept.made.volume == before
    assert all(np.array_equal(found[name], kept.contents[name]) for name in found)


def frame_of(device, vpls: np.ndarray, moving: np.ndarray) -> SimpleNamespace:
    words = traits.pack_traits(np.zeros((len(vpls), 3)), np.ones(len(vpls)), moving)
    return SimpleNamespace(
        vpls=record_texture(device, "vpls", VPL, len(vpls), vpls),
        vpl_surfaces=word_texture(device, "surfaces", len(vpls), words), lamp_layers=(),
        lights=SimpleNamespace(lamps=1), vpl_ranges=[(0, len(vpls))], vpl_widths=[64],
        gpu_scene=SimpleNamespace(is_moving=moving, static_version=0, left_boxes=NOTHING),
    )  # fmt: skip


@pytest.mark.parametrize("planes", [False, True], ids=["shares", "planes"])
def test_static_surfels_stay_and_others_do_not(device, planes):
    """Of frames in some of which a third of the surfels move: the volume is the maximum of what has been static in any
    and of all that this one has. Sums err by half a step of fixed point for each surfel, and by 1e-5 for normals and
    areas in float32."""
    made, rng = GeometryVolume(device, LEVELS, camera=False, planes=planes), np.random.default_rng(3)
    kept, grid, scene, static = made.keeping(), device.uniform("grid", pack_grid(GRID)), None, []
    for moves in (False, True, False, True):
        vpls, moving = random_surfels(rng, 2000, 0.05), moves & (rng.random(2000) < 0.3)
        frame = frame_of(device, vpls, moving)
        frame.gpu_scene = scene = scene or frame.gpu_scene
        scene.is_moving = moving
        with one_stage(device) as stage:
            kept.follow(stage, [GRID], scene)
            made.run(stage, frame, grid, kept=kept)
        static.append(shares_of(vpls[~moving], planes))
        expected = geometry.merge_buffers([*static, shares_of(vpls, planes)])
        bound = 50 * 0.5 / fixed_point_wall(2000, planes)  # more than any cell has
        np.testing.assert_allclose(made.blocked()[0], expected, rtol=1e-5, atol=bound)
    assert np.any(expected > geometry.merge_buffers(static) + bound)  # what moved is there
    assert np.any(expected > shares_of(vpls, planes) + bound)  # and what was


def shares_of(vpls: np.ndarray, planes: bool) -> np.ndarray:
    """Of one buffer; with planes of its larger side."""
    return geometry.inject_planes(*surfels_of(vpls)).shares if planes else geometry.inject_surfels(*surfels_of(vpls))


def test_planes_of_what_is_kept_lie_where_they_did(device):
    """Those of the buffer that has the most, kept or new, the first of equals."""
    made, rng = GeometryVolume(device, LEVELS, camera=False), np.random.default_rng(4)
    kept, grid, scene, seen = made.keeping(), device.uniform("grid", pack_grid(GRID)), None, []
    for _ in range(3):
        vpls = random_surfels(rng, 2000, 0.05)
        frame = frame_of(device, vpls, np.zeros(2000, bool))
        frame.gpu_scene = scene = scene or frame.gpu_scene
        with one_stage(device) as stage:
            kept.follow(stage, [GRID], scene)
            made.run(stage, frame, grid, kept=kept)
        seen.append(geometry.inject_planes(*surfels_of(vpls)))
    merged = geometry.merge_planes(seen)
    found = read_buffer(device, made.volume["offsets"]).reshape(-1, 4)[: N**3, :3].reshape(N, N, N, 3)
    order = np.sort([planes.shares for planes in seen], axis=0)
    sure = (order[-1] > 1e-2) & (order[-1] - order[-2] > 1e-4)  # rounding does not choose another
    np.testing.assert_allclose(found[sure], merged.offsets[sure], atol=1e-3)
    assert sure.mean() > 0.1


def test_shifted_contents_stay_in_the_world():
    """Each cell of the window has what its place in the world had, if that was in the window."""
    z, y, x = np.indices((N, N, N))
    for shift in ((0, 0, 0), (3, -5, 7), (N - 1, 1 - N, 0), (N, 0, 0), (0, 0, -N - 4)):
        found = shifted(1.0 + x + 100.0 * y + 1e4 * z, shift)
        i, j, k = x + shift[0], y + shift[1], z + shift[2]
        inside = (np.minimum(np.minimum(i, j), k) >= 0) & (np.maximum(np.maximum(i, j), k) < N)
        assert np.array_equal(found, np.where(inside, 1.0 + i + 100.0 * j + 1e4 * k, 0.0))


def test_windows_that_move_are_known_again():
    """By whole cells, as float64 has their origins; others are not."""
    grid = Grid((1e3 + 0.1, -7.3, 0.7), 0.1, N)
    for shift in ((0, 0, 0), (4, -8, 100)):
        assert window_shift(grid, moved(grid, *shift)) == shift
    assert window_shift(grid, moved(grid, 0.5, 0, 0)) is None
    assert window_shift(grid, Grid(grid.origin, 0.2, N)) is None


def test_forgotten_cells_hold_all_of_a_box():
    """Every cell that a point in the box, or up to a cell and a half aside, lies in, and none two cells away."""
    rng = np.random.default_rng(5)
    low = rng.uniform(-2.0, 1.0, (3, 3)) + np.array(GRID.origin) + 1.0
    high = low + rng.uniform(0.0, 1.5, (3, 3))
    found = forgotten_cells(GRID, low, high, 0.5)
    reach = 1.5 * GRID.cell_size
    for a, b in zip(low, high, strict=True):
        places = rng.uniform(a - reach, b + reach, (4000, 3))
        x, y, z = GRID.cell_of(places[GRID.inside(places)]).T
        assert found[z, y, x].all()
    middles = GRID.cell_centres()[found]
    away = np.maximum(low[:, None] - middles, middles - high[:, None]).max(axis=-1).min(axis=0)
    assert found.any() and not found.all() and away.max() <= 2.0 * GRID.cell_size
