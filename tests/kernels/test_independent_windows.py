"""What is far away does not depend on where the finer windows lie: surfaces, light, nodes and bounces of the last."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
from gpu_tools import one_stage, read_buffer
from test_cascades import COUNT, LEVELS, VOLUME, N, random_vpls

from octolux.frame import traits
from octolux.frame.structs import VPL
from octolux.gpu.records import read_records, record_texture, word_texture
from octolux.simulator.lpv import cascades
from octolux.techniques.lpv.bouncing.bounces import Bounces
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.gathering.gathering import NODE, Gathering
from octolux.techniques.lpv.geometry import GeometryVolume
from octolux.techniques.lpv.injection import Injection, VplSource
from octolux.techniques.lpv.reflectors import Reflectors
from octolux.techniques.lpv.windows import pack_windows

CAMERAS = [-0.5, 0.3, 0.1], [0.6, -0.4, 0.2]
BOUNCES = 2
FIRST = LEVELS.first(COUNT - 1)  # cell of the last window


@cache
def around(device, camera: int) -> SimpleNamespace:
    """All that windows around a camera make of the same surfels: of the last window and the levels above."""
    vpls, rng = random_vpls(6000), np.random.default_rng(2)
    vpls["area"] *= 20.0
    words = traits.pack_traits(rng.random((len(vpls), 3)), np.ones(len(vpls)), np.zeros(len(vpls), bool))
    frame = SimpleNamespace(
        vpls=record_texture(device, "vpls", VPL, len(vpls), vpls),
        vpl_surfaces=word_texture(device, "surfaces", len(vpls), words), lights=SimpleNamespace(lamps=1),
        vpl_ranges=[(0, len(vpls))], vpl_widths=[64], lamp_layers=(),
    )  # fmt: skip
    placed = cascades.place_windows(N, COUNT, VOLUME, CAMERAS[camera], [0.0, 0.0, 0.0])
    grids = device.uniform("grids", pack_grids(cascades.grids_of(placed, VOLUME)))
    windows = device.uniform("windows", pack_windows(placed))
    injection = Injection(device, N, cells=LEVELS.cells, grids=COUNT, moments=True)
    geometry, reflectors = GeometryVolume(device, LEVELS, False), Reflectors(device, LEVELS, 0.5, False, places=True)
    gathering = Gathering(device, LEVELS, occlusion=False, lookup_offset=0.5, placed=True)
    bounces = Bounces(device, LEVELS, BOUNCES, occlusion=False)
    source = VplSource(0, len(vpls), vpls["flux"].sum(axis=0, dtype=np.float64))
    with one_stage(device) as stage:
        injection.run(stage, grids, frame.vpls, [source])
        geometry.run(stage, frame, grids)
        geometry.pack(stage)
        reflectors.run(stage, frame, grids)
        gathering.forget(stage)
        gathering.measure(stage, injection.injected, windows, injection.moments)
        gathering.finish(stage, injection.injected)
    before = read_buffer(device, injection.injected).reshape(-1, 3, 4)[FIRST : LEVELS.cells]
    with one_stage(device) as stage:
        bounces.run(stage, injection.injected, gathering.moments, injection.peak, reflectors, None, windows)
    cells = COUNT * N**3
    return SimpleNamespace(
        placed=placed, packed=read_buffer(device, geometry.packed, np.uint32).reshape(-1, 4)[FIRST : LEVELS.cells],
        reflectors=read_buffer(device, reflectors.reflectors).reshape(-1, 12)[FIRST:cells],
        places=read_buffer(device, reflectors.places).reshape(-1, 4)[FIRST:cells], before=before,
        bounced=read_buffer(device, injection.injected).reshape(-1, 3, 4)[FIRST:cells] - before[: N**3],
        moments=read_buffer(device, gathering.moments).reshape(-1, 4)[FIRST:cells],
        nodes=read_records(device, gathering.nodes, NODE, LEVELS.cells)[FIRST:],
    )  # fmt: skip


def test_windows_lie_elsewhere(device):
    one, other = (around(device, camera).placed for camera in range(2))
    assert all(a.origin != b.origin for a, b in zip(one[:-1], other[:-1], strict=True)) and one[-1] == other[-1]


def test_surfaces_are_the_same_to_the_bit(device):
    one, other = (around(device, camera) for camera in range(2))
    for name in ("packed", "reflectors", "places"):
        assert np.array_equal(getattr(one, name), getattr(other, name)) and getattr(one, name).any()


def test_light_is_the_same_to_the_bit(device):
    """And where it comes from."""
    one, other = (around(device, camera) for camera in range(2))
    assert np.array_equal(one.before, other.before)
    assert all(np.array_equal(one.nodes[name], other.nodes[name]) for name in ("place", "weight", "red_green", "blue"))
    assert np.count_nonzero(one.nodes["weight"]) > 1000


def test_bounces_are_the_same_to_the_bit(device):
    """Light and moments: irradiance in half floats too, as its scale is a power of two."""
    one, other = (around(device, camera) for camera in range(2))
    assert np.array_equal(one.bounced, other.bounced) and np.array_equal(one.moments, other.moments)
    assert np.count_nonzero(one.bounced[:, 0, 0]) > 500 and one.bounced.max() > 0.1 * one.before[: N**3].max()
