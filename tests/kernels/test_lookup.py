"""Lookup (volumes.wgsl, lookup.wgsl) against the simulator's, and the two cases known in closed form.

The G-buffer is made here: random normals and points, packed as the G-buffer packs them.
"""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import wgpu
from gpu_tools import one_stage, random_directions

from octolux.frame.frame import TEXTURE, FrameBuffers
from octolux.frame.lights import light_set
from octolux.frame.views import camera_view
from octolux.frame.visibility import DrawList
from octolux.scene.cameras import Camera
from octolux.simulator import sh
from octolux.simulator.camera import octahedral_decode, octahedral_encode, pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import lookup as reference
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.lookup import CHANNELS, Lookup

N, SIZE = 8, (48, 20)
GRID = Grid((-1.0, -1.0, -1.0), 0.25, N)
CAMERA = Camera.look_at((0.3, -0.2, 2.5), (0.1, 0.0, 0.0))
THESIS_SCALE = 1.7
# Texture units may round each of the three weights of a sample to 1/256, that is by 1/512.
WEIGHT_ERROR = 3 / 512


@cache
def lookup(device, reading: str, damping: bool, offset: float) -> Lookup:
    return Lookup(device, N, reading=reading, damping=damping, lookup_offset=offset, scale=THESIS_SCALE)


def picture_texture(device, data: np.ndarray, format: str):
    height, width = data.shape[:2]
    made = device.texture("made by a test", (width, height), format, usage=TEXTURE | wgpu.TextureUsage.COPY_DST)
    layout = {"bytes_per_row": data.nbytes // height, "rows_per_image": height}
    device.queue.write_texture({"texture": made}, np.ascontiguousarray(data), layout, (width, height, 1))
    return made


@cache
def gbuffer(device) -> SimpleNamespace:
    """A frame with random points (some outside the volume, some pixels empty) and normals; what it holds as float64."""
    width, height = SIZE
    rng = np.random.default_rng(0)
    normals, geometric = (random_directions(rng, width * height).reshape(height, width, 3) for _ in range(2))
    codes = np.rint((octahedral_encode(geometric) * 0.5 + 0.5) * 4095).astype(np.uint32)
    surface = np.zeros((height, width, 4), np.uint32)
    surface[..., 0] = pack_normals(normals)
    surface[..., 1] = codes[..., 0] | codes[..., 1] << 12
    depth = rng.uniform(0.8, 4.0, (height, width)).astype(np.float32)
    depth[::5, ::7] = 0.0
    view = camera_view(CAMERA, width, height, 10.0)
    lights, nothing = light_set([], (np.zeros(3), np.ones(3)), 8), DrawList([], np.zeros((0, 2), np.uint32))
    frame = SimpleNamespace(
        pixels=SIZE, buffers=FrameBuffers(device).upload(lights, [view], nothing),
        targets=SimpleNamespace(
            surface=picture_texture(device, surface, "rgba32uint"), depth=picture_texture(device, depth, "r32float")
        ),
    )  # fmt: skip
    x = ((np.arange(width) + 0.5) / width * 2 - 1)[None, :, None]
    y = (1 - (np.arange(height) + 0.5) / height * 2)[:, None, None]
    points = view.position + depth[..., None] * (view.forward + x * view.right + y * view.up)
    inside = (depth > 0) & np.all((points >= -1) & (points <= 1), axis=-1)
    geometric = octahedral_decode(codes / 4095 * 2 - 1)
    return SimpleNamespace(
        frame=frame, points=points, normals=unpack_normals(surface[..., 0]), geometric=geometric, inside=inside
    )


def scale_of(light: np.ndarray) -> np.float32:
    """The power of two that brings the largest band 0 into [8, 16), as storage_scale.wgsl says."""
    return np.float32(2.0 ** (3 - np.floor(np.log2(light[..., 0].max()))))


def read(device, made: Lookup, light: np.ndarray) -> np.ndarray:
    """Irradiance (height, width, 3) that the device reads in `light` (W/sr)."""
    made.prepare(SIZE)
    scaled = device.buffer("light", (light * scale_of(light)).astype(np.float32))
    peak = device.buffer("peak", np.array([light[..., 0].max()], np.float32))
    grid = device.uniform("grid", pack_grid(GRID))
    with one_stage(device) as stage:
        made.write_volumes(stage, scaled)
        made.read(stage, gbuffer(device).frame, grid, peak)
    return device.read_texture(made.irradiance, np.float32, 4)[..., :3].astype(np.float64)


def stored(device, made: Lookup, light: np.ndarray) -> np.ndarray:
    """What the half-float volumes hold after `read`, in W/sr: float64 [z][y][x][rgb][4]."""
    layout = {"bytes_per_row": N * 8, "rows_per_image": N}
    halves = [device.queue.read_texture({"texture": made.volumes[c]}, layout, (N, N, N)) for c in CHANNELS]
    cells = [np.frombuffer(h, np.float16).reshape(N, N, N, 4) for h in halves]
    return np.stack(cells, axis=3).astype(np.float64) / scale_of(light)


def smooth_light(seed: int, roughness: float = 0.15, grid: Grid = GRID) -> np.ndarray:
    """Light that varies across the volume about once, and by `roughness` from cell to cell."""
    rng = np.random.default_rng(seed)
    centre = grid.cell_centres()
    light = np.empty((*centre.shape[:3], 3, 4), np.float32)
    for channel in range(3):
        light[..., channel, 0] = 2.0 + np.sin(centre @ rng.normal(size=3)) + rng.uniform(0, roughness, centre.shape[:3])
        turned = np.stack([np.cos(centre @ rng.normal(size=3)) for _ in range(3)], axis=-1)
        light[..., channel, 1:] = turned * light[..., channel, :1] * rng.uniform(0.1, 0.6)
    return light


def spread(light: np.ndarray, points: np.ndarray, grid: Grid = GRID) -> np.ndarray:
    """Largest minus smallest of the eight cells around `points`, for each coefficient: (..., 3, 4). Beyond the centres
    of the outermost cells the two outermost: adapters may clamp the coordinate and round the weight afterwards."""
    low = np.clip(np.floor(grid.to_cells(points) - 0.5).astype(int), 0, grid.n - 2)
    high = np.minimum(low + 1, grid.n - 1)
    corners = [np.where(np.array(c, bool), high, low) for c in np.ndindex(2, 2, 2)]
    cells = np.stack([light[c[..., 2], c[..., 1], c[..., 0]] for c in corners])
    return cells.max(axis=0) - cells.min(axis=0)


def sensitivity(reading: str, change: np.ndarray, grid: Grid = GRID) -> np.ndarray:
    """Most that irradiance changes when the coefficients change by `change` (..., 3, 4), from each reading's formula.

    dominant_lobe: E h^2 = 2 sqrt(pi) c00 / 6 plus sqrt(3 pi) c1 . (max(0, -n.d) d - d / 6), and its form for a = 1.
    """
    band0, band1 = change[..., 0], np.linalg.norm(change[..., 1:], axis=-1)
    if reading == "thesis":
        return THESIS_SCALE * (sh.COSINE_LOBE_0 * band0 + sh.COSINE_LOBE_1 * band1)
    if reading == "paper":
        return 4 / grid.cell_size**2 * (sh.Y0 * band0 + sh.Y1 * band1)
    return (2 * np.sqrt(np.pi) * band0 + 7 / 6 * np.sqrt(3 * np.pi) * band1) / grid.cell_size**2


def test_volumes_hold_the_light(device):
    """Half floats have 11 bits, and adapters may round or truncate: one unit in the last place, 2^-10."""
    light, made = smooth_light(4), lookup(device, "paper", False, 0.0)
    read(device, made, light)
    np.testing.assert_allclose(stored(device, made, light), light, rtol=2**-10, atol=1e-7 * light.max())


@pytest.mark.parametrize("offset", [0.0, 0.5])
@pytest.mark.parametrize("reading", reference.READINGS)
def test_every_reading(device, reading, offset):
    light, g, made = smooth_light(1), gbuffer(device), lookup(device, reading, False, offset)
    found = read(device, made, light)
    volume, places = stored(device, made, light), g.points + offset * GRID.cell_size * g.geometric
    sampled = reference.sample_trilinear(volume, GRID, places)
    expected = reference.irradiance(sampled, g.normals, GRID.cell_size, reading, THESIS_SCALE)
    # Beside the weights, 1e-4 of the light there for float32 arithmetic (positions: 1e-6 of a cell).
    bound = sensitivity(reading, WEIGHT_ERROR * spread(volume, places) + 1e-4 * np.abs(sampled))
    difference = np.abs(found - expected)
    assert np.all(difference[g.inside] <= bound[g.inside])
    assert np.median(bound[g.inside]) < 0.05 * np.median(expected[g.inside]), "the bound says nothing"


@pytest.mark.parametrize("reading", reference.READINGS)
def test_derivative_damping(device, reading):
    """Light that falls off across the volume is damped where it falls along the normal."""
    light, g = smooth_light(2, roughness=0.02), gbuffer(device)
    light *= np.exp(-1.5 * GRID.cell_centres()[..., :1, None]).astype(np.float32)
    made = lookup(device, reading, True, 0.0)
    found = read(device, made, light)
    volume = stored(device, made, light)
    sampled = reference.sample_trilinear(volume, GRID, g.points)
    kept = reference.damping(volume, GRID, g.points, g.geometric)
    full = reference.irradiance(sampled, g.normals, GRID.cell_size, reading, THESIS_SCALE)
    # The factor is c.(c + g) / c.c: with errors of e in c and 2 e in g it moves by at most 4 |e| / |c|, and first order
    # in e / c is enough, as g is at most |c| here.
    error = WEIGHT_ERROR * spread(volume, g.points)
    half = 0.5 * GRID.cell_size * g.geometric
    for place in (g.points + half, g.points - half):
        error = np.maximum(error, WEIGHT_ERROR * spread(volume, place))
    error = error + 1e-4 * np.abs(sampled)
    relative = np.linalg.norm(error, axis=-1) / np.linalg.norm(sampled, axis=-1)
    bound = sensitivity(reading, error) + 4 * relative * full
    difference = np.abs(found - kept * full)
    assert np.all(difference[g.inside] <= bound[g.inside])
    assert (kept[g.inside] < 0.9).mean() > 0.2 and (kept[g.inside] == 1).mean() > 0.2


def test_outside_the_volume_is_dark(device):
    found = read(device, lookup(device, "dominant_lobe", False, 0.5), smooth_light(1))
    inside = gbuffer(device).inside
    assert not found[~inside].any()
    assert (~inside).sum() > 100 and inside.sum() > 100


@pytest.mark.parametrize(("reading", "beam", "furnace"), [("dominant_lobe", 1.0, 1.0), ("paper", 0.955, 1.910)])
def test_beam_and_furnace(device, reading, beam, furnace):
    """Flux F through every cell along d gives E = F / h^2 on a plane across it, and isotropic flux F in
    every cell F / (6 h^2); the paper's reading has 0.955 and 1.910 of it (3 figures: 5e-4). Half floats: 2^-11."""
    made, g = lookup(device, reading, False, 0.0), gbuffer(device)
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[..., 0] = 2.0 * sh.Y0 / (4 * np.pi * sh.Y0**2)  # flux 2
    found = read(device, made, light)[g.inside] / (2.0 / (6 * GRID.cell_size**2))
    np.testing.assert_allclose(found, furnace, atol=2e-3)

    light[:] = 2.0 / np.pi * sh.cosine_lobe([0.0, 0.6, -0.8])
    cosine = -(g.normals @ [0.0, 0.6, -0.8])
    facing = g.inside & (cosine > 0.99)
    assert facing.any()
    found = read(device, made, light)[facing] / (2.0 / GRID.cell_size**2)
    # Two-band SH: (1 + 2 cos) / 4 of the lobe's 3/4; the dominant lobe follows the cosine itself.
    shape = cosine if reading == "dominant_lobe" else (1 + 2 * cosine) / 3
    np.testing.assert_allclose(found, (beam * shape[facing])[:, None] * np.ones(3), atol=2e-3)
