"""Reflectors on the device (techniques/lpv/reflectors*.wgsl) against the simulator's, and a wall seen."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, read_buffer, scene_of, small_settings

from octolux.frame import traits
from octolux.frame.peeling import LampLayer
from octolux.frame.structs import VPL
from octolux.gpu.device import DeviceError
from octolux.gpu.records import record_texture, word_texture
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.environment import LUMINANCE
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import reflectors as reference
from octolux.simulator.lpv.geometry import BEHIND
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.reflectors import Reflectors
from octolux.techniques.settings import Settings

N = 16
GRIDS = [Grid((-1.0, -0.5, 2.0), 0.25, N), Grid((-2.5, -2.5, 0.5), 0.5, N), Grid((-5.5, -5.0, -4.0), 1.0, N)]
OFFSETS = [0.5, -BEHIND]
FIXED_POINT = 0.5 / 65536  # of a share, for each surfel
TINT_FIXED_POINT = 0.5 / 2**20  # of albedo times area in cross sections, for each surfel
ARITHMETIC = 1e-5  # normals and areas in float32


def random_surfels(rng, count: int, area: float) -> tuple[np.ndarray, np.ndarray]:
    """VPLs in and around the grids and their surfaces' traits. None comes within 1e-3 cells of a face, where float32
    and float64 may choose other cells; every seventh texel meets nothing."""
    vpls = VPL.array(count)
    vpls["normal"] = pack_normals(random_directions(rng, count))
    grid = np.array(rng.choice(len(GRIDS), count))
    origin, size = np.array([g.origin for g in GRIDS])[grid], np.array([g.cell_size for g in GRIDS])[grid]
    vpls["position"] = origin + size[:, None] * rng.uniform(-2, N + 2, (count, 3))
    vpls["area"] = rng.uniform(0.0, area, count) * size**2
    vpls["area"][3::7] = 0.0
    for grid in GRIDS:
        for offset in OFFSETS:
            normal = unpack_normals(vpls["normal"])
            cells = grid.to_cells(vpls["position"].astype(np.float64)) + offset * normal
            vpls["area"][(np.abs(cells - np.rint(cells)) < 1e-3).any(axis=1)] = 0.0
    words = traits.pack_traits(rng.random((count, 3)), np.ones(count), np.zeros(count, bool))
    return vpls, words


def arguments(vpls: np.ndarray, words: np.ndarray) -> list[np.ndarray]:
    there = vpls["area"] > 0
    position, area = (vpls[name][there].astype(np.float64) for name in ("position", "area"))
    return [position, unpack_normals(vpls["normal"][there]), area, traits.unpack_traits(words[there])[0]]


def layer_of(device, groups) -> LampLayer:
    vpls, words = (np.concatenate([g[k] for g in groups]) for k in range(2))
    surfaces = word_texture(device, "surfaces", len(vpls), words)
    return LampLayer(record_texture(device, "vpls", VPL, len(vpls), vpls), surfaces)


def run(
    device, made: Reflectors, groups, grids=GRIDS, lamps: int | None = None, width: int = 1, further=()
) -> np.ndarray:
    """[grid][z][y][x][3][4]; a group is a light's VPLs in rows of `width`, and the first `lamps` lights count.
    further: groups of the lights' further layers, of the same sizes."""
    starts, first = np.cumsum([0, *(len(vpls) for vpls, _ in groups)]).tolist(), layer_of(device, groups)
    frame = SimpleNamespace(
        vpls=first.vpls, vpl_surfaces=first.surfaces, lamp_layers=[layer_of(device, layer) for layer in further],
        lights=SimpleNamespace(lamps=len(groups) if lamps is None else lamps),
        vpl_ranges=[(s, len(g[0])) for s, g in zip(starts, groups, strict=False)], vpl_widths=[width] * len(groups),
    )  # fmt: skip
    with one_stage(device) as stage:
        made.run(stage, frame, device.uniform("grids", pack_grids(grids)))
    cells = len(grids) * N**3
    return read_buffer(device, made.reflectors)[: cells * 12].reshape(len(grids), N, N, N, 3, 4)


def made_of(device, offset: float, *, grids: int = len(GRIDS), camera: bool = False, places=False) -> Reflectors:
    return Reflectors(device, Levels([N] * grids, grids), offset, camera, places=places)


@pytest.fixture(scope="module")
def made(device) -> Reflectors:
    return made_of(device, 0.5, places=True)


def check(found: np.ndarray, groups, grid: Grid, offset: float) -> np.ndarray:
    """Shares err by half a step of fixed point for each surfel; albedos by what that makes of their sums. Returns how
    much [z][y][x]."""
    buffers = []
    count, walls = np.zeros((N, N, N)), np.zeros((N, N, N))
    for group in groups:
        position, normal, area, albedo = arguments(*group)
        buffers.append(reference.inject_reflectors(position, normal, area, albedo, grid, offset))
        count += reference.inject_reflectors(position, normal, np.full(len(area), grid.cell_size**2), albedo, grid,
                                             offset)[1][..., 3]  # fmt: skip
        walls += buffers[-1][1][..., 3]
    expected = reference.merge_reflectors(buffers)
    np.testing.assert_allclose(found[..., :2, :], expected[..., :2, :], rtol=ARITHMETIC, atol=count.max() * FIXED_POINT)
    lost = 2.0 * count * TINT_FIXED_POINT / np.where(walls > 0, walls, 1.0)
    assert np.all(np.abs(found[..., 2, :] - expected[..., 2, :]) <= lost[..., None] + ARITHMETIC)
    assert (walls > 0).mean() > 0.05 and lost.max() < 0.05
    return lost


@pytest.mark.parametrize("places", [False, True])
@pytest.mark.parametrize("offset", OFFSETS)
def test_surfels_of_many_lights_in_nested_grids(device, offset, places):
    """More lights than have sums of their own at once; each surfel is in every grid that holds it. Places are twice
    what their sums say, of which the cell size takes 1e-5 for those in float32."""
    rng = np.random.default_rng(1)
    groups = [random_surfels(rng, count, 0.5) for count in (60000, 30000, 1, 9000, 5000, 4000)]
    made = made_of(device, offset, places=places)
    found = run(device, made, groups)
    assert (made.places is not None) == places
    position, normal, area = (np.concatenate(a) for a in zip(*(arguments(*g)[:3] for g in groups), strict=True))
    for number, grid in enumerate(GRIDS):
        lost = check(found[number], groups, grid, offset)
        if places:
            expected = reference.inject_places(position, normal, area, grid, offset)
            there = read_buffer(device, made.places).reshape(len(GRIDS), N, N, N, 4)[number]
            assert np.all(np.abs(there[..., :3] - expected) <= 2.0 * lost[..., None] + ARITHMETIC)
            assert not there[..., 3].any() and np.abs(expected).max() > 0.4
    assert 0.001 < (found[..., 0, :] == 1.0).mean() < 0.95


def test_a_single_grid(device):
    group = random_surfels(np.random.default_rng(2), 30000, 0.1)
    found = run(device, made_of(device, 0.5, grids=1), [group], GRIDS[:1])
    check(found[0], [group], GRIDS[0], 0.5)


def test_layers_of_a_light_are_summed(device, made):
    """As if they were one buffer's; albedos are the mean of all."""
    rng = np.random.default_rng(7)
    layers = [[random_surfels(rng, count, 0.3) for count in (9000, 4000)] for _ in range(3)]
    found = run(device, made, layers[0], further=layers[1:])
    together = [tuple(map(np.concatenate, zip(*groups, strict=True))) for groups in zip(*layers, strict=True)]
    for number, grid in enumerate(GRIDS):
        check(found[number], together, grid, 0.5)


@pytest.mark.parametrize("width", [3, 64, 1000, 5000])
def test_any_width_of_the_map_gives_the_same_bits(device, made, width):
    """Texels that are below one another share cells, or do not; rows are whole, or are not."""
    vpls, words = random_surfels(np.random.default_rng(3), 20001, 0.3)
    order = np.argsort(np.floor(vpls["position"]) @ [1, 100, 10000], kind="stable")
    group = vpls[order], words[order]
    plain = run(device, made, [group])
    assert np.array_equal(plain, run(device, made, [group], width=width)) and plain.any()


def test_frames_are_independent(device, made):
    """Nothing is left of a frame with more surfels and more lights."""
    rng = np.random.default_rng(4)
    few = [random_surfels(rng, 500, 0.3)]
    first = run(device, made, few)
    run(device, made, [random_surfels(rng, 9000, 0.3) for _ in range(6)])
    assert np.array_equal(first, run(device, made, few)) and first.any()


def test_soft_lights_do_not_count(device, made):
    rng = np.random.default_rng(5)
    groups = [random_surfels(rng, 500, 0.3) for _ in range(2)]
    assert np.array_equal(run(device, made, groups[:1]), run(device, made, groups, lamps=1))
    assert not run(device, made, groups, lamps=0).any()


def test_a_cell_with_too_much(device, made):
    """A hundred thousand surfels larger than anything in one cell of each grid: no sum overflows, and the means are
    those of all."""
    vpls = VPL.array(100_000)
    vpls["normal"], vpls["area"] = pack_normals(np.array([0.0, 0.0, 1.0])), 1e3
    vpls["position"] = np.array(GRIDS[0].origin) + 5.3 * GRIDS[0].cell_size
    albedo = np.random.default_rng(6).random((len(vpls), 3)) ** 2
    words = traits.pack_traits(albedo, np.ones(len(vpls)), np.zeros(len(vpls), bool))
    found = run(device, made, [(vpls, words)])
    cell = found[0, 5, 5, 5]
    assert np.array_equal(cell[:2].ravel(), [0, 0, 0, 0, 1, 0, 0, 0])
    mean = traits.unpack_traits(words)[0].mean(axis=0)
    np.testing.assert_allclose(cell[2], [*mean, mean @ LUMINANCE], rtol=1e-6)
    assert [np.count_nonzero(cells) for cells in found] == [5, 5, 5]
    places = read_buffer(device, made.places).reshape(3, N, N, N, 4)
    np.testing.assert_allclose(places[0, 5, 5, 5], [-0.2, -0.2, -0.2, 0.0], atol=ARITHMETIC)
    assert [np.count_nonzero(cells) for cells in places] == [3, 3, 3]


def test_more_cells_than_fit_are_refused(device):
    with pytest.raises(DeviceError, match="smaller n"):
        Reflectors(device, Levels([128, 128], 2), 0.5)


# A wall of 2 x 2 m between two cells, red from before and from behind.
WALL = quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
AROUND = Grid((-2.0, -2.0, -2.0), 0.25, N)
LAMP = PointLight(position=(0.0, 0.0, 1.5), intensity=(1.0, 1.0, 1.0))


class Seeing(NoTechnique):
    """A technique that has reflectors around the wall."""

    needs = frozenset({"rsm", "surfaces"})

    def __init__(self, device, offset: float, camera: bool):
        super().__init__(device, Settings())
        self.reflectors = made_of(device, offset, grids=1, camera=camera)
        self.grids = device.uniform("grids", pack_grids([AROUND]))

    def update(self, frame) -> None:
        with frame.profiler.stage("reflectors") as stage:
            self.reflectors.run(stage, frame, self.grids)


@pytest.mark.parametrize("names", ["lamp", "camera", "lamp camera"])
@pytest.mark.parametrize(("offset", "before", "behind"), [(0.5, 8, 7), (-BEHIND, 7, 8)])
def test_a_wall_in_a_picture(device, names, offset, before, behind):
    """The wall fills one layer of cells, and faces the side it is seen from: a lamp and the camera stand before it and
    a lamp behind. A cell is 21 texels of the lamps' maps wide (256 over 3 m) and 29 pixels of the picture (256 over
    2.2 m); of them at most one row at either end of each direction is another cell's."""
    lamps = [LAMP, PointLight(position=(0.0, 0.0, -1.5), intensity=(1.0, 1.0, 1.0))] if "lamp" in names else []
    scene = scene_of([WALL], [Material(base_color=(0.8, 0.2, 0.1), double_sided=True)], lights=lamps)
    renderer = Renderer(
        scene, "none", size=(256, 256), device=device, default_light=False, exposure=0.0,
        frame_settings=small_settings(shadow_resolution=256, rsm_resolution=256, sky_lights=0, emitter_lights=0),
    )  # fmt: skip
    renderer.technique = seeing = Seeing(device, offset, "camera" in names)
    renderer.render(Camera.look_at((0.0, 0.0, 1.5), (0.0, 0.0, 0.0), vertical_fov=2 * np.arctan(1.1 / 1.5)))
    cells = read_buffer(device, seeing.reflectors.reflectors).reshape(N, N, N, 3, 4)
    inside = slice(4, 12)  # of 16 cells in x and y
    seen = [(before, 4)] + ([(behind, 5)] if "lamp" in names else [])
    for layer, side in seen:
        shares = cells[layer, inside, inside].reshape(8, 8, 12)
        assert shares[..., side].max() <= 1.0 and shares[..., side].min() > (1 - 2 / 21) ** 2
        # The albedo's square root has 8 bits: 1/255 at most (frame/traits.py); the G-buffer's 16 add 2^-17.
        np.testing.assert_allclose(shares[..., 8:11], np.broadcast_to((0.8, 0.2, 0.1), (8, 8, 3)), atol=1 / 255)
        np.testing.assert_allclose(shares[..., 11], shares[..., 8:11] @ LUMINANCE, rtol=1e-6)
        # Normals have 12 bits in the G-buffer and 16 in an RSM.
        assert np.delete(shares[..., :8], side, axis=-1).max() <= 1e-3
        cells[layer, inside, inside] = 0.0
    assert not cells.any()
