"""What static surfaces reflect, kept from frame to frame, against the simulator's."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_reflectors import GRIDS, N, arguments, layer_of, made_of, random_surfels

from octolux.frame import traits
from octolux.simulator.lpv import reflectors as reference
from octolux.simulator.lpv.keeping import has_seen_more, merge_kept_reflectors
from octolux.techniques.lpv.constants import pack_grids

COUNT, GRID = 6000, GRIDS[0]


def of(vpls: np.ndarray, words: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reflectors [z][y][x][3][4] and places [z][y][x][3] of one buffer."""
    given = arguments(vpls, words)
    made = reference.merge_reflectors([reference.inject_reflectors(*given, GRID, 0.5)])
    return made, reference.inject_places(*given[:3], GRID, 0.5)


@pytest.mark.parametrize("places", [False, True])
def test_static_reflectors_stay_and_others_do_not(device, places):
    """In some frames a third of the surfels move. Shares err by half a step of fixed point for each surfel, of which no
    cell has fifty; albedos and places of cells with a hundredth of a wall by 50 / 2^20 of that, and 1e-5. Who has seen
    more is decided by rounding where both have seen as much."""
    made, rng = made_of(device, 0.5, grids=1, places=places), np.random.default_rng(1)
    kept, grid = made.keeping(), device.uniform("grids", pack_grids([GRID]))
    scene = SimpleNamespace(is_moving=np.zeros(0, bool), static_version=0, left_boxes=np.zeros((2, 0, 3)))
    older: tuple[np.ndarray, np.ndarray] | None = None
    for moves in (False, True, False, True):
        vpls, words = random_surfels(rng, COUNT, 0.1)
        scene.is_moving = moves & (rng.random(COUNT) < 0.3)
        albedo, size, _ = traits.unpack_traits(words)
        words = traits.pack_traits(albedo, size, scene.is_moving)
        layer = layer_of(device, [(vpls, words)])
        frame = SimpleNamespace(
            vpls=layer.vpls, vpl_surfaces=layer.surfaces, lamp_layers=(), lights=SimpleNamespace(lamps=1),
            vpl_ranges=[(0, COUNT)], vpl_widths=[64], gpu_scene=scene,
        )  # fmt: skip
        with one_stage(device) as stage:
            kept.follow(stage, [GRID], scene)
            made.run(stage, frame, grid, kept=kept)
        older = joined(of(vpls[~scene.is_moving], words[~scene.is_moving]), older)
        newer = of(vpls, words)
        expected, where = joined(newer, older)
        found = read_buffer(device, made.reflectors).reshape(-1, 3, 4)[: N**3].reshape(N, N, N, 3, 4)
        np.testing.assert_allclose(found[..., :2, :], expected[..., :2, :], rtol=1e-5, atol=50 * 0.5 / 65536)
        seen = [both[..., :2, :].sum(axis=(-2, -1)) for both in (newer[0], older[0])]
        filled = (np.maximum(*seen) > 0.01) & ((np.abs(seen[0] - seen[1]) > 1e-3) | ~scene.is_moving.any())
        assert filled.mean() > 0.2
        np.testing.assert_allclose(found[filled][:, 2], expected[filled][:, 2], atol=50 / 2**20 / 0.01 + 1e-5)
        if places:
            there = read_buffer(device, made.places).reshape(N, N, N, 4)[..., :3]
            np.testing.assert_allclose(there[filled], where[filled], atol=2.0 * 50 / 2**20 / 0.01 + 1e-5)


def joined(newer, older) -> tuple[np.ndarray, np.ndarray]:
    if older is None:
        return newer
    more = has_seen_more(newer[0], older[0])
    return merge_kept_reflectors(newer[0], older[0]), np.where(more[..., None], newer[1], older[1])
