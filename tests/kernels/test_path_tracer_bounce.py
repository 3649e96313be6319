"""What the path tracer draws at a surface: bounces, directions to the sky, emitters; densities, weights, energy.

Chi-square tests have a significance of 1e-3 for all of this file together; seeds are fixed.
"""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np
import pytest
from chi_square import TOGETHER, HemisphereBins, p_value
from gpu_tools import TESTS, one_stage, random_directions, read_buffer
from path_tracing import directional_albedo

from octolux.frame.environment import SurroundingsMap
from octolux.frame.shader_values import CONSTANTS
from octolux.frame.structs import ENVIRONMENT, LIGHT, lights_binding
from octolux.gpu.bindings import storage, storage_rw, storage_words, texture, uniform
from octolux.gpu.passes import ComputePass
from octolux.scene.environment import Environment
from octolux.simulator import brdf
from octolux.simulator.environment import LUMINANCE, texel_solid_angles
from octolux.techniques.path_tracer.emitters import EMITTER, EmitterList, _packed, sky_table
from octolux.techniques.path_tracer.technique import PATHS

ROW = 1 << 15
ROUNDING = 2.0**-23
DRAWS = 1 << 17
# 12 of bounces, 4 of the sky, 2 of emitters.
SIGNIFICANCE = TOGETHER / 18
DARK = Environment()
NO_EMITTERS = EmitterList(EMITTER.array(1), 0, 0.0)


def run(device, mode: str, inputs, outputs: int, environment=DARK, emitters=NO_EMITTERS) -> np.ndarray:
    data = np.ascontiguousarray(inputs, dtype=np.float32)
    map_ = SurroundingsMap(device)
    map_.sync(environment)
    table, sky_power = (np.zeros((1, 1, 4), np.float32), 0.0) if environment.is_black else sky_table(environment)
    sky = device.texture("sky", (table.shape[1], table.shape[0]), "rgba32float", usage=map_._table.usage)
    device.write_layer(sky, table)
    settings = PATHS.array(1)
    settings["emitters"], settings["inverse_sky"] = len(emitters.rows), 1.0 / sky_power if sky_power else 0.0
    settings["inverse_emission"] = 1.0 / emitters.power if emitters.power else 0.0
    given, result = device.buffer("given", data), device.buffer("result", size=len(data) * outputs * 4)
    kernel = ComputePass(
        device, "path sampling", str(TESTS / "kernels" / "path_sampling.wgsl"),
        [storage("given", "f32"), storage_rw("result", "f32", "write"), uniform("settings", PATHS), lights_binding(),
         storage_words("emitters", EMITTER), texture("sky_table"), *SurroundingsMap.bindings()],
        structs=[PATHS, LIGHT, EMITTER, ENVIRONMENT], workgroup=(64, 1, 1), threads=len(data), mode=mode, row=ROW,
        inputs=data.shape[1], outputs=outputs, sky=1, emitters=True, emissive=False, area_lights=0, lamps=0, cut=False,
        particles=False, slots=set(), shadows=False, luminance=f"vec3f({', '.join(map(str, LUMINANCE))})", **CONSTANTS,
    )  # fmt: skip
    with one_stage(device) as stage:
        kernel.run(
            stage, (min(len(data), ROW), -(-len(data) // ROW)), given=given, result=result, sky_table=sky,
            settings=device.uniform("settings", settings), lights=device.uniform("lights", LIGHT.array(256)),
            emitters=device.buffer("emitters", emitters.rows), **map_.resources,
        )  # fmt: skip
    return read_buffer(device, result)[: len(data) * outputs].reshape(len(data), outputs).astype(np.float64)


def even(seed: int, count: int = DRAWS, numbers: int = 3) -> np.ndarray:
    """Independent draws in the sampler's steps of 2^-24."""
    return np.random.default_rng(seed).integers(0, 1 << 24, (count, numbers)) / (1 << 24)


def eye_at(n_v: float, turn: float = 0.7) -> np.ndarray:
    across = np.sqrt(1.0 - n_v * n_v)
    return np.array([across * cos(turn), across * sin(turn), n_v])


def rows(count: int, eye, roughness: float, metallic: float, base=(0.8, 0.5, 0.3), specular: float = 1.0) -> np.ndarray:
    """(count, 12): a surface that faces +z."""
    return np.tile([0, 0, 1, *eye, *base, roughness, metallic, specular], (count, 1))


@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
@pytest.mark.parametrize(("roughness", "n_v"), [(0.3, 0.8), (0.3, 0.2), (0.6, 0.5), (1.0, 0.1)])
def test_bounces_have_the_density_that_is_claimed(device, metallic, roughness, n_v):
    bins, eye = HemisphereBins(), eye_at(n_v)
    drawn = run(device, "bounce", np.column_stack([rows(DRAWS, eye, roughness, metallic), even(1)]), 7)
    assert np.abs(np.linalg.norm(drawn[:, :3], axis=1) - 1).max() <= 32 * ROUNDING
    points = bins.points()
    claimed = run(device, "density", np.column_stack([rows(len(points), eye, roughness, metallic), points]), 1)[:, 0]
    probabilities = bins.probabilities(claimed)
    assert probabilities[:-1].sum() <= 1 + 1e-3  # the midpoint rule's error
    assert p_value(bins.counts(drawn[:, :3]), probabilities) > SIGNIFICANCE
    # The density that comes with a bounce is the same one.
    again = run(device, "density", np.column_stack([rows(DRAWS, eye, roughness, metallic), drawn[:, :3]]), 1)[:, 0]
    alpha = float(brdf.alpha_of(roughness))
    # As for the BRDF (test_shaders.py), here of the half vector of a rounded direction.
    np.testing.assert_allclose(drawn[:, 3], again, rtol=1e-4 + 32 * ROUNDING / alpha**2)


CASES = [(r, m, n_v) for r in (0.05, 0.2, 0.5, 1.0) for m in (0.0, 0.3, 1.0) for n_v in (0.95, 0.5, 0.1)]


@pytest.fixture(scope="module")
def weights(device) -> np.ndarray:
    """Of 2^14 bounces for each of CASES: (cases, draws, 3)."""
    count = 1 << 14
    given = np.concatenate([
        np.column_stack([rows(count, eye_at(n_v), r, m), even(i + 10, count)]) for i, (r, m, n_v) in enumerate(CASES)
    ])  # fmt: skip
    return run(device, "bounce", given, 7)[:, 4:].reshape(len(CASES), count, 3)


@pytest.mark.parametrize("case", range(len(CASES)), ids=[f"roughness {r}, metallic {m}, n.v {v}" for r, m, v in CASES])
def test_the_mean_weight_of_a_bounce_is_the_albedo(weights, case):
    """Within 4 standard errors; 36 cases of three colours that go together: 0.2 % that chance alone fails one."""
    roughness, metallic, n_v = CASES[case]
    expected = directional_albedo(brdf.surface((0.8, 0.5, 0.3), metallic, roughness), eye_at(n_v))
    found = weights[case]
    error = found.std(axis=0) / np.sqrt(len(found))
    assert np.all(np.abs(found.mean(axis=0) - expected) <= 4 * error + 1e-4)  # of the midpoint rule and float32


def test_weights_are_small(weights):
    """What a bounce is multiplied by: the lobes' mixture leaves no weight above a few."""
    assert weights.min() >= 0 and weights.max() <= 4


def test_white_metal_reflects_no_more_than_it_receives(device):
    """The specular weight is F G2 / G1 at most 1 for each bounce, so also its mean."""
    for roughness in (0.1, 0.5, 1.0):
        for n_v in (0.9, 0.2):
            given = rows(1 << 12, eye_at(n_v), roughness, 1.0, base=(1.0, 1.0, 1.0))
            weight = run(device, "bounce", np.column_stack([given, even(3, 1 << 12)]), 7)[:, 4:]
            alpha = float(brdf.alpha_of(roughness))
            assert weight.max() <= 1 + 1e-4 + 64 * ROUNDING / alpha**2
            assert weight.mean() > 0.3


@pytest.mark.parametrize(("degrees", "gain"), [(0.0, 1.0), (60.0, 1.02), (89.0, 1.23)])
def test_white_dielectric_gains_what_the_mixed_fresnel_gives_it(device, degrees, gain):
    """The known limit of the BRDF (simulator/brdf.py), to its two decimals and within 4 standard errors."""
    given = rows(1 << 15, eye_at(cos(radians(degrees))), 0.4, 0.0, base=(1.0, 1.0, 1.0))
    weight = run(device, "bounce", np.column_stack([given, even(4, 1 << 15)]), 7)[:, 4]
    assert abs(weight.mean() - gain) <= 0.005 + 4 * weight.std() / np.sqrt(len(weight))


def test_reciprocity(device):
    """f(l, v) = f(v, l): reflection divided by its cosine, for random surfaces."""
    rng = np.random.default_rng(5)
    count = 20000
    eye, light = random_directions(rng, count), random_directions(rng, count)
    eye[:, 2], light[:, 2] = np.maximum(np.abs(eye[:, 2]), 0.01), np.maximum(np.abs(light[:, 2]), 0.01)
    eye, light = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (eye, light))
    roughness = rng.uniform(0.1, 1, count)
    rest = [rng.uniform(0, 1, (count, 3)), roughness, rng.uniform(0, 1, (count, 2))]
    normal = np.tile([0.0, 0.0, 1.0], (count, 1))
    there = run(device, "reflection", np.column_stack([normal, eye, *rest, light]), 3) / light[:, 2:]
    back = run(device, "reflection", np.column_stack([normal, light, *rest, eye]), 3) / eye[:, 2:]
    tolerance = 1e-4 + 16 * ROUNDING / brdf.alpha_of(roughness) ** 2
    largest = np.maximum(there, back).max(axis=1)
    assert np.all(np.abs(there - back).max(axis=1) <= tolerance * largest)


def test_nothing_is_reflected_through_a_surface(device):
    """From below the geometric or the shading normal, whichever way the other points."""
    light = np.array([[0.0, 0.6, -0.8], [1.0, 0.0, 0.0]])
    assert not run(device, "reflection", np.column_stack([rows(2, eye_at(0.5), 0.5, 0.5), light]), 3).any()


def sky_of(kind: str) -> Environment:
    rng = np.random.default_rng(8)
    if kind == "constant":
        return Environment((1.0, 2.0, 3.0))
    image = rng.random((16, 32, 3)).astype(np.float32)
    if kind == "sun":
        image[4, 9] = 1e4
    if kind == "stripes":  # of a map so large that 24 bits leave five for each texel's alias
        image = np.tile(np.float32([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0])[:, None], (512, 128, 3)).astype(np.float32)
        image = np.ascontiguousarray(image.reshape(512, 1024, 3) + np.float32(1e-3))
    return Environment((0.0,) * 3, image, rotation=1.0)


@pytest.mark.parametrize("kind", ["constant", "random", "sun", "stripes"])
def test_directions_to_the_sky_have_the_density_that_is_claimed(device, kind):
    environment = sky_of(kind)
    u = even(6, numbers=4)
    drawn = run(device, "sky", u, 4, environment)
    assert np.abs(np.linalg.norm(drawn[:, :3], axis=1) - 1).max() <= 8 * ROUNDING
    table, power = sky_table(environment)
    height, width = table.shape[:2]
    azimuth = np.arctan2(drawn[:, 0], -drawn[:, 2]) + environment.rotation
    column = (0.5 + azimuth / (2 * pi)) % 1.0 * width
    row = np.arccos(np.clip(drawn[:, 1], -1, 1)) / pi * height
    cell = np.floor([row, column]).astype(int) % [[height], [width]]
    light = table[..., 2] * texel_solid_angles(height, width) / power
    if kind == "stripes":  # dark and bright columns, 8 together; rows in 16 groups
        cell = np.stack([cell[0] // 32, cell[1] % 8])
        light = light.reshape(16, 32, 128, 8).sum(axis=(1, 2))
    counts = np.zeros(light.shape)
    np.add.at(counts, tuple(cell), 1)
    assert p_value(counts, light) > SIGNIFICANCE
    # The density led back from the direction, as a reflected ray finds it, but for directions at a texel's edge.
    found = run(device, "sky density", drawn[:, :3], 1, environment)[:, 0]
    assert np.mean(np.abs(found / drawn[:, 3] - 1) > 1e-4) <= 0.02


@pytest.mark.parametrize("kind", ["few", "many"])
def test_emitters_are_chosen_by_their_power(device, kind):
    rng = np.random.default_rng(9)
    count = {"few": 3, "many": 1000}[kind]
    corners = rng.normal(size=(count, 3, 3))
    radiance = rng.random((count, 3)) ** 4
    if kind == "many":
        radiance[::3] = 0.0
    found, total = _packed(corners, np.arange(count), np.zeros(count, bool), radiance)
    drawn = run(device, "emitter", even(7, numbers=1), 2, emitters=EmitterList(found, 0, total))
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    power = radiance @ LUMINANCE * area
    assert total == pytest.approx(power.sum())
    number = drawn[:, 0].astype(int)
    assert p_value(np.bincount(number, minlength=count), power / power.sum()) > SIGNIFICANCE
    # Per area: the chance of the triangle over its area.
    np.testing.assert_allclose(drawn[:, 1], (power / power.sum() / area)[number], rtol=1e-5)
    assert power[number].min() > 0


def test_a_bounce_from_a_slanted_surface_is_turned_with_it(device):
    """The same draws in another frame: the same density and weight to every direction of the local frame."""
    n = np.array([0.48, -0.6, 0.64])
    eye = n * 0.6 + 0.8 * np.array([0.8, 0.0, -0.6])
    given = rows(DRAWS, eye / np.linalg.norm(eye), 0.4, 0.5)
    given[:, :3] = n
    drawn = run(device, "bounce", np.column_stack([given, even(12)]), 7)
    upright = rows(DRAWS, eye_at(float(eye @ n)), 0.4, 0.5)
    other = run(device, "bounce", np.column_stack([upright, even(13)]), 7)
    for a, b in ((drawn[:, :3] @ n, other[:, 2]), *zip(drawn[:, 4:].T, other[:, 4:].T, strict=True)):
        assert abs(a.mean() - b.mean()) <= 4 * np.hypot(a.std(), b.std()) / np.sqrt(DRAWS)
