"""Cones through nested windows (passing.wgsl) against the simulator's, way by way. What they should do:
tests/analytic/test_simulator_cones.py."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_cascades import COUNT, WINDOWS, N, uniforms
from test_octree_gathering import packed, random_planes

from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.simulator.lpv import cones, geometry
from octolux.techniques.lpv.constants import STRIP_VALUES
from octolux.techniques.lpv.gathering.gathering import _OPAQUE
from octolux.techniques.lpv.windows import WINDOW, windows_binding

KERNEL = """
{{ use("techniques/lpv/gathering/levels.wgsl") }}
{{ use("techniques/lpv/gathering/passing.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= {{ count }}u { return; }
    let way = ends[id.x].xyz - starts[id.x].xyz;
    let cone = Cone(ends[id.x].w, starts[id.x].w, {{ cone_length }});
    found[id.x] = passing(starts[id.x].xyz, normalize(way), length(way), cone, {{ base }}u);
}
"""


def ways(base: int, straight: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From the middles of a window's cells to anywhere in the volume, or along its axes to other cells' middles, in
    cells of its level: start, end (M, 3), and sizes of nodes (M,) as large as may be."""
    rng, window, count, edge = np.random.default_rng(base), WINDOWS[base], 3000, N << (COUNT - 1 - base)
    low, high = np.clip(np.array(window.ends) - np.reshape(window.origin, (1, 3)), 0.5, N - 0.5)
    start = np.floor(rng.uniform(low, high, (count, 3))) + window.origin + 0.5
    end = rng.uniform(0.0, edge, (count, 3))
    if straight:
        axis = np.arange(3) == rng.integers(0, 3, (count, 1))
        end = np.where(axis, np.floor(end) + 0.5, start)
    away = np.abs(end - start).max(axis=-1)
    far = away >= 1.5  # as nodes are that are read
    return start[far], end[far], 2.0 ** np.floor(np.log2(away[far] / 1.5))


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("base", range(COUNT))
@pytest.mark.parametrize("narrower", [1.0, 2.0])
def test_ways_pass_as_the_simulators(device, tmp_path, base, straight, narrower):
    """Into nodes that go on from the way's end by up to their size. But for what is black, and where float32 chooses: a
    place along a way that is right to 1e-5 cells lies so near to one of some hundred planes or faces once in a thousand
    times. Straight ways go through the middles of cells."""
    rng = np.random.default_rng(7)
    planes = [random_planes(rng, 0.25) for _ in range(COUNT)]
    words, blockers = packed([*planes, *geometry.plane_levels(planes[-1])[1:]])
    start, end, size = ways(base, straight)
    room, cone_length = (rng.random(len(size)) * size).astype(np.float32), narrower * cones.CONE_LENGTH
    (tmp_path / "k.wgsl").write_text(KERNEL)
    kernel = ComputePass(
        device, "cones", str(tmp_path / "k.wgsl"),
        [storage("starts", "vec4f"), storage("ends", "vec4f"), storage("geometry", "vec4u"), windows_binding(COUNT),
         storage_rw("found", "f32", "write")],
        structs=[WINDOW], workgroup=(64, 1, 1), count=len(start), base=base, n=N, windows=COUNT,
        bits=N.bit_length() - 1, cone_length=cone_length, fade=cones.FADE, left_out=cones.LEFT_OUT,
        short=cones.SHORT, opaque=_OPAQUE, strips_first=0, **STRIP_VALUES,
    )  # fmt: skip
    given = (np.column_stack(columns).astype(np.float32) for columns in ((start, room), (end, size)))
    buffers = dict(zip(("starts", "ends"), (device.buffer("ways", rows) for rows in given), strict=True))
    found = device.buffer("found", size=len(start) * 4)
    with one_stage(device) as stage:
        kernel.run(
            stage, (len(start),), geometry=device.buffer("words", words), windows=uniforms(device)[1], found=found,
            **buffers,
        )  # fmt: skip
    above = len(blockers) - COUNT
    origins = np.array([*[w.origin for w in WINDOWS], *[(0, 0, 0)] * above])
    ends = np.array([*[w.ends for w in WINDOWS], *[cones.WHOLE] * above])
    expected = cones.cone_transmittance(
        blockers[base:], start, end.astype(np.float32), size, origins[base:], ends[base:], room=room,
        cone_length=cone_length,
    )  # fmt: skip
    right = np.abs(read_buffer(device, found)[: len(start)] - expected) <= 2.0 * _OPAQUE + 1e-5
    assert right.mean() >= (1.0 if straight else 0.998)
    assert 0.05 < expected.mean() < 0.9
