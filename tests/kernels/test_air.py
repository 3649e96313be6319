"""Light in the air of gathered cascades (cascaded/air.wgsl): fluence of even light and of beams, and what fog gets."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, read_buffer, small_settings
from test_cascades import COUNT, LEVELS, WINDOWS, N
from test_octree_gathering import STORED

import octolux
from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.renderer import Renderer
from octolux.scene.medium import Medium
from octolux.simulator.lpv import cascades
from octolux.simulator.lpv.gathering import first_moments, gather
from octolux.techniques.lpv.cascaded.air import AirLight
from octolux.techniques.lpv.constants import storage_scale

HALF_FLOAT = 2.0**-10  # 2^-11 rounded, twice that where an adapter truncates
KERNEL = """
{{ use("techniques/lpv/cascaded/air.wgsl") }}

@compute @workgroup_size({{ workgroup }})
fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x < {{ count }}u { found[id.x] = vec4f(volume_fluence(places[id.x].xyz), volume_step(places[id.x].xyz)); }
}
"""


def rendered(device, technique: str, **settings):
    scene = replace(octolux.load("cornell-box"), medium=Medium(scattering=(0.05,) * 3, absorption=(0.0,) * 3))
    renderer = Renderer(scene, technique, settings=settings, size=(64, 36), exposure=0.0, device=device,
                        frame_settings=small_settings(fog_resolution=1))  # fmt: skip
    return renderer, renderer.render()


@pytest.fixture(scope="module")
def foggy(device):
    return rendered(device, "cascaded-lpv", n=16, cascades=2, bounces=1)


def even_cube(device, light, value: np.ndarray):
    """The cube's texture with the same irradiance (lx times a cell's area, scaled) on the six faces of all cells."""
    n = light.values["air_n"]
    texels = np.ones((6, n, n, n, 4), np.float16)
    texels[..., :3] = value[:, None, None, None, None]
    usage = light.resources["air_cube"].usage | 2
    texture = device.texture("cube", (n, n, 6 * n), "rgba16float", usage=usage, dimension="3d")
    layout = {"bytes_per_row": n * 8, "rows_per_image": n}
    device.queue.write_texture({"texture": texture}, texels, layout, texture.size)
    return texture


@pytest.mark.parametrize(
    "irradiance, fluence", [([pi] * 6, 4 * pi), ([2, 0, 0, 0, 0, 0], 4 / 3), ([3**-0.5, 0] * 3, 2 / 3**0.5)]
)
def test_fluence(device, tmp_path, foggy, irradiance, fluence):
    """Of even radiance 1 its integral 4 pi; of a beam along an axis two thirds; of one between them 2 / sqrt(3).
    Nothing beyond the volume. Steps are as long as the cells, twice those of the last cascade."""
    technique = foggy[0].technique
    grid, light = technique.cascades.grids[-1], technique.way.air.light
    peak = float(read_buffer(device, technique.way.injection.peak)[0])
    value = np.array(irradiance) * storage_scale(peak) * (2.0 * grid.cell_size) ** 2
    rng = np.random.default_rng(1)
    places = np.zeros((50, 4), np.float32)
    places[:, :3] = grid.origin + 16.0 * grid.cell_size * rng.random((50, 3))
    places[40:, 0] += 16.0 * grid.cell_size
    (tmp_path / "k.wgsl").write_text(KERNEL)
    kernel = ComputePass(
        device, "air", str(tmp_path / "k.wgsl"),
        [*light.bindings, storage("places", "vec4f"), storage_rw("found", "vec4f", "write")], structs=light.structs,
        workgroup=(64, 1, 1), count=len(places), **light.values,
    )  # fmt: skip
    found = device.buffer("found", size=len(places) * 16)
    resources = {**light.resources, "air_cube": even_cube(device, light, value)}
    with one_stage(device) as stage:
        kernel.run(stage, (len(places),), **resources, places=device.buffer("places", places), found=found)
    read = read_buffer(device, found).reshape(-1, 4)
    np.testing.assert_allclose(read[:40, :3], fluence, rtol=2 * HALF_FLOAT)
    assert not read[40:, :3].any()
    np.testing.assert_allclose(read[:, 3], 2.0 * grid.cell_size, rtol=1e-6)


def test_the_air_gathers_from_where_light_lies(device):
    """As the simulator's gathering of all cells of the level above the windows, from the moments that are given."""
    rng = np.random.default_rng(3)
    light, placed = np.zeros((COUNT, N, N, N, 3, 4)), rng.uniform(-1.0, 1.0, (COUNT, N, N, N, 3))
    light[..., 0] = rng.uniform(0.1, 2.0, light.shape[:-1]) * (rng.random((COUNT, N, N, N, 1)) < 0.02)
    light[..., 1:] = random_directions(rng, light[..., 0].size).reshape(*light.shape[:-1], 3) * light[..., :1]
    placed *= light[..., 0].sum(axis=-1)[..., None]
    moments = [first_moments(a, w.origin, w.size, b) for a, w, b in zip(light, WINDOWS, placed, strict=True)]
    levels = [cascades.window_levels(values) for values in (light, moments)]
    given = [np.concatenate([each.reshape(each.shape[0] ** 3, -1) for each in all_of]) for all_of in levels]
    injected, moments, peak = (
        device.buffer("given", values.astype(np.float32)) for values in (*given, given[0][:1, :1] * 0.0 + 8.0)
    )
    windows = SimpleNamespace(n=N, count=COUNT, grids_buffer=None)
    air, frame = AirLight(device, windows, LEVELS, occlusion=False), SimpleNamespace()
    with one_stage(device) as stage:
        air.run(stage, frame, injected, moments, peak, None)
    half = N // 2
    data = device.queue.read_texture(
        {"texture": frame.volume_light.resources["air_cube"]}, {"bytes_per_row": half * 8, "rows_per_image": half},
        (half, half, 6 * half),
    )  # fmt: skip
    cube = np.frombuffer(data, np.float16).reshape(6, half, half, half, 4).astype(np.float64)
    cells = rng.integers(0, half, (20, 3))
    nodes = cascades.window_nodes(light, WINDOWS, placed)
    expected = gather(cells, nodes, 1.0, base=COUNT)
    found = np.moveaxis(cube[:, cells[:, 2], cells[:, 1], cells[:, 0], :3], 0, 1)
    allowed = HALF_FLOAT * expected + STORED * expected.max(axis=1, keepdims=True)
    assert np.all(np.abs(found - expected) <= allowed) and expected.min(axis=0).max() > 0.0
    elsewhere = gather(cells, cascades.window_nodes(light, WINDOWS), 1.0, base=COUNT)
    assert np.any(np.abs(elsewhere - expected) > 2.0 * allowed), "places hardly matter"


def test_fog_has_indirect_light(device, foggy):
    """More than lamps bring directly, everywhere that fog is seen."""
    _, direct = rendered(device, "none")
    added = foggy[1].layers["fog"] - direct.layers["fog"]
    assert added.min() >= -1e-6 * direct.layers["fog"].max() and added.mean() > 0.0
