"""What bounces after the last bring, against the simulator's (simulator/voxels/series.py)."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage
from voxel_tools import pack_bright

from octolux.simulator.voxels.series import gain
from octolux.techniques.voxel_cones.bricks.representation import REPRESENTATIONS
from octolux.techniques.voxel_cones.light.series import SERIES, Received, Series
from octolux.techniques.voxel_cones.views.contents import unpack_bright

BEGIN, FIRST_BRICK = 40, 3
NODES = 500


def octree(device, bricks: int, kept: str, shown: np.ndarray) -> SimpleNamespace:
    """Bricks of nodes of which any has any; the node's code is twice its number."""
    owners = np.arange(FIRST_BRICK + bricks, dtype=np.uint32) % NODES << 3
    representation = REPRESENTATIONS[kept]
    buffers = {"owners": owners, "codes": 2 * np.arange(NODES, dtype=np.uint32), "shown": shown}
    given = {name: device.buffer(name, data) for name, data in buffers.items()}
    resource = SimpleNamespace(resource=given["owners"])
    return SimpleNamespace(
        bricks=SimpleNamespace(representation=representation, owners=resource),
        octree=SimpleNamespace(codes=SimpleNamespace(resource=given["codes"]), shown=given["shown"]),
        nodes=np.repeat(owners[FIRST_BRICK:] >> 3, 8 * representation.sides),
    )


@pytest.mark.parametrize("kept", REPRESENTATIONS)
@pytest.mark.parametrize("moving", [False, True])
def test_as_the_simulator(device, kept, moving):
    """Three bounces, of more sides than there are sums and of fewer; then other ones from the start, of which nothing
    of the former is left. Where something moves, nodes that its octree has are taken from there alone."""
    rng = np.random.default_rng(0)
    bits = rng.integers(0, 2**32, 2 * NODES // 32 + 1, dtype=np.uint32)
    octrees = [octree(device, bricks, kept, bits) for bricks in ((900, 60) if moving else (900,))]
    taken = [np.full(len(one.nodes), True) for one in octrees]
    if moving:
        codes = [2 * one.nodes for one in octrees]
        taken = [(bits[code >> 5] >> (code & 31) & 1) == i for i, code in enumerate(codes)]
        assert all(0.3 < t.mean() < 0.7 for t in taken)
    made = Series(device, octrees)
    for ratios in ((0.5, 0.8, 0.2), (0.3, 0.1, 0.6)):
        received, sums = [np.zeros((len(one.nodes), 3)) for one in octrees], []
        for number in range(3):
            received = [old + np.array(ratios) ** number * rng.uniform(0.0, 0.1, old.shape) for old in received]
            words = [np.concatenate([np.full(BEGIN, 2**32 - 1, np.uint32), pack_bright(part)]) for part in received]
            light = [unpack_bright(part[BEGIN:])[t] for part, t in zip(words, taken, strict=True)]
            sums.append(sum(part.sum(axis=0) for part in light))
            given = [Received(device.buffer("received", w), BEGIN, len(w) - BEGIN, FIRST_BRICK) for w in words]
            with one_stage(device) as stage:
                made.follow(stage, number, given)
            found = np.frombuffer(device.queue.read_buffer(made.result), SERIES.dtype)[0]
            # Each side is rounded down to 2^-22, and sums to float32. A ratio is of differences of two of them, and
            # its error is that of the gain times r (1 - r), at least 0.09.
            off, least = sum(t.sum() for t in taken) * 2.0**-22, np.diff([np.zeros(3), *sums], axis=0).min()
            np.testing.assert_allclose(found["sum"], sums[-1], atol=off, rtol=2.0**-23)
            off += 2.0**-23 * sums[-1].max()
            np.testing.assert_allclose(found["gain"], gain(sums), rtol=2.0 * off / least / 0.09)
        assert (found["gain"] > 0.05).all()
