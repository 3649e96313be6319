"""The shared shaders against the simulator, through small kernels that stand beside this file."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import random_directions, run_kernel

from octolux.frame.composite import _FUNCTIONS as FUNCTIONS
from octolux.frame.shader_values import CONSTANTS
from octolux.simulator import brdf, camera, sh, tonemap
from octolux.techniques.lpv.constants import SH_CONSTANTS

AXES = np.concatenate([np.eye(3), -np.eye(3), np.array([[1, 1, 0], [0, -1, 1], [-1, 0, -1]]) / np.sqrt(2)])
EPSILON = 2.0**-23


def test_octahedral(device):
    v = np.concatenate([AXES, random_directions(np.random.default_rng(0), 5000)])
    packed = camera.pack_normals(v)
    found = run_kernel(device, "octahedral.wgsl", np.column_stack([v, packed & 0xFFFF, packed >> 16]), 5)
    np.testing.assert_allclose(found[:, 2:], camera.unpack_normals(packed), atol=4 * EPSILON)
    bits = found[:, 0].astype(np.uint32) | found[:, 1].astype(np.uint32) << 16
    words = [camera.unpack_snorm2x16(b) * 32767 for b in (bits, packed)]
    # Rounding may go either way within float32 of a half; the fold keeps zeros' sides.
    assert np.abs(words[0] - words[1]).max() <= 1
    assert (words[0] != words[1]).mean() < 0.01
    assert np.array_equal(words[0][:6], words[1][:6])


def random_surfaces(rng, count: int, roughness: tuple[float, float]) -> np.ndarray:
    """The (count, 15) numbers brdf.wgsl takes; nine in ten lights and eyes are above the surface."""
    n = random_directions(rng, count)
    turned = []
    for v in (random_directions(rng, count), random_directions(rng, count)):
        below = ((v * n).sum(axis=1) < 0) & (rng.random(count) < 0.9)
        turned.append(np.where(below[:, None], -v, v))
    base, metallic = rng.uniform(0, 1, (count, 3)), rng.choice([0.0, 0.3, 1.0], count)
    rest = [base, rng.uniform(*roughness, count), metallic, rng.uniform(0, 1, count)]
    return np.column_stack([n, *turned, *rest]).astype(np.float32)


@pytest.mark.parametrize("roughness", [(0.3, 1.0), (0.0, 0.3)], ids=["rough", "glossy"])
def test_brdf(device, roughness):
    """1e-4 for roughness from 0.3. In a highlight 1 - (n.h)^2 (1 - alpha^2) falls to alpha^2 = roughness^4, while n.h
    is known to some 4 roundings: D, which has its square, is then as uncertain as 16 roundings over alpha^2. An eye
    below the surface may lie almost opposite to the light: the sum of both, at most 2 long, keeps their roundings."""
    given = random_surfaces(np.random.default_rng(1), 20000, roughness)
    g = given.astype(np.float64)
    n, light, eye = g[:, :3], g[:, 3:6], g[:, 6:9]
    material = brdf.surface(g[:, 9:12], g[:, 13], g[:, 12], g[:, 14])
    above = (n * light).sum(1) > 1e-3
    found = run_kernel(device, "brdf.wgsl", given, 3, **CONSTANTS)
    expected = brdf.evaluate(material, n, light, eye)
    tolerance = 1e-4 + 16 * EPSILON / brdf.alpha_of(material.roughness) ** 2
    tolerance *= 2 / np.linalg.norm(light + eye, axis=1)
    error = np.abs(found - expected).max(axis=1) / expected.max(axis=1, where=above[:, None], initial=1e-30)
    assert above.mean() > 0.7
    assert (above & ((n * eye).sum(1) < 0)).mean() > 0.03
    assert np.all(error[above] <= tolerance[above])
    assert np.isfinite(found).all()


def test_brdf_in_the_highlight(device):
    """Eye and light mirrored at the normal, where D is largest, for all roughnesses."""
    roughness = np.linspace(0.05, 1, 200)
    n = np.tile([0.0, 0.0, 1.0], (200, 1))
    light = np.tile([0.6, 0.0, 0.8], (200, 1))
    eye = light * [-1, 1, 1]
    given = np.column_stack([n, light, eye, np.full((200, 3), 0.5), roughness, np.zeros(200), np.ones(200)])
    found = run_kernel(device, "brdf.wgsl", given, 3, **CONSTANTS)
    expected = brdf.evaluate(brdf.surface(np.full((200, 3), 0.5), 0.0, roughness, 1.0), n, light, eye)
    tolerance = 1e-4 + 16 * EPSILON / brdf.alpha_of(roughness) ** 2
    assert np.all(np.abs(found / expected - 1) <= tolerance[:, None])


def test_gbuffer_packing(device):
    """Each field comes back within half a step of its bits: 16 for colours, 8 for others; normals within theirs."""
    rng = np.random.default_rng(2)
    count = 3000
    normals = np.concatenate([AXES, random_directions(rng, count - len(AXES))])
    rest = rng.uniform(0, 1, (count, 6))
    rest[:20] = rng.integers(0, 2, (20, 6))
    found = run_kernel(device, "gbuffer.wgsl", np.column_stack([normals, normals[::-1], rest]), 12)
    assert np.linalg.norm(np.cross(found[:, :3], normals), axis=1).max() <= 6.5e-5
    assert np.linalg.norm(np.cross(found[:, 3:6], normals[::-1]), axis=1).max() <= np.sqrt(18) / 4095
    assert np.min((found[:, :3] * normals).sum(1)) > 0.99 and np.min((found[:, 3:6] * normals[::-1]).sum(1)) > 0.99
    assert np.abs(found[:, 6:9] - rest[:, :3]).max() <= 0.5 / 65535 + EPSILON
    assert np.abs(found[:, 9:] - rest[:, 3:]).max() <= 0.5 / 255 + EPSILON
    assert np.array_equal(found[:20, 6:], rest[:20])


# Sums of a few float32 numbers, some of which cancel. AgX: its polynomial's coefficients have a sum of 95, its outset
# magnifies differences by 1.3 and its power by 2.2: 95 * 1.3 * 2.2 roundings of 2^-23.
TONE_MAP_ERROR = {"none": 0.0, "neutral": 5e-6, "aces": 2e-6, "agx": 3.3e-5}


def test_tone_map_and_transfer(device):
    rng = np.random.default_rng(3)
    colors = np.concatenate([
        rng.uniform(0, 1, (2000, 3)), 10 ** rng.uniform(-4, 4, (2000, 3)),
        np.repeat(np.linspace(0, 2, 300)[:, None], 3, axis=1),
        [[0.08, 0.5, 0.9], [0.76, 0.76, 0.76], [0.8, 0.8, 0.8], [0.0, 0.0, 0.0], [0.0031308] * 3],
    ])  # fmt: skip
    maps = list(tonemap.TONE_MAPS)
    found = run_kernel(device, "tonemap.wgsl", colors, 15, functions=[FUNCTIONS[name] for name in maps], **CONSTANTS)
    given = colors.astype(np.float32).astype(np.float64)
    # pow() of the encoding is exp2(y log2 x): some 1e-6 of the result; both are in [0, 1].
    np.testing.assert_allclose(found[:, :3], tonemap.srgb_encode(given), atol=2e-5)
    for name, mapped in zip(maps, np.split(found[:, 3:], len(maps), axis=1), strict=True):
        np.testing.assert_allclose(mapped, tonemap.TONE_MAPS[name](given), atol=TONE_MAP_ERROR[name], err_msg=name)


def test_spherical_harmonics(device):
    rng = np.random.default_rng(4)
    c, d = rng.normal(size=(4000, 4)), random_directions(rng, 4000)
    c[:2000, 0] = np.abs(c[:2000, 0]) * 3 + 0.1
    c[-4:] = [[0, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [-1, 0, 1, 0]]
    given = np.column_stack([c, d]).astype(np.float32)
    found = run_kernel(device, "sh.wgsl", given, 10, **SH_CONSTANTS)
    c, d = given[:, :4].astype(np.float64), given[:, 4:].astype(np.float64)
    np.testing.assert_allclose(found[:, 0], sh.evaluate(c, d), atol=1e-6 * 5)
    np.testing.assert_allclose(found[:, 1:5], sh.cosine_lobe(d), atol=1e-6)
    flux, fraction, direction = sh.dominant_lobe(c)
    np.testing.assert_allclose(found[:, 5], flux, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found[:, 6], fraction, atol=2e-6)
    np.testing.assert_allclose(found[:, 7:], direction, atol=2e-6)
