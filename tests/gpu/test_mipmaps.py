"""Size classes and mip chains."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.gpu_scene.mipmaps import mip_chain, size_class
from octolux.scene.materials import Image
from octolux.simulator.tonemap import srgb_decode, srgb_encode


def image(height: int, width: int, color=(10, 20, 30, 255)) -> Image:
    return Image(np.broadcast_to(np.array(color, np.uint8), (height, width, 4)).copy())


@pytest.mark.parametrize(("height", "width", "expected"), [
    (1, 1, 256), (256, 256, 256), (256, 257, 512), (100, 1000, 1024), (1024, 3, 1024), (2048, 2048, 2048),
    (1, 2049, 2048), (5000, 4000, 2048),
])  # fmt: skip
def test_size_classes(height, width, expected):
    assert size_class(image(height, width)) == expected


@pytest.mark.parametrize("srgb", [True, False])
@pytest.mark.parametrize(("height", "width"), [(256, 256), (1, 1), (3, 200), (400, 100), (3000, 20)])
def test_a_constant_image_stays_constant(height, width, srgb):
    """Also in transparent parts: the colours of masks and of data textures count whatever their alpha."""
    for color in [(10, 200, 37, 255), (1, 254, 128, 3), (255, 0, 77, 0)]:
        for level in mip_chain(image(height, width, color), 256, srgb):
            assert level.dtype == np.uint8 and np.all(level == np.array(color))


def test_shapes_of_a_chain():
    chain = mip_chain(image(300, 500), 512, True)
    assert [level.shape for level in chain] == [(512 >> i, 512 >> i, 4) for i in range(10)]


@pytest.mark.parametrize("srgb", [True, False])
def test_every_code_survives(srgb):
    """4 x 4 blocks of one code each: six levels on, averages of equal texels still are that code."""
    codes = np.arange(256, dtype=np.uint8)
    for first in range(0, 256, 16):
        blocks = np.repeat(np.repeat(codes[first : first + 16].reshape(4, 4), 64, axis=0), 64, axis=1)
        level = mip_chain(Image(np.repeat(blocks[..., None], 4, axis=2)), 256, srgb)[6]
        assert np.array_equal(level[..., 0], codes[first : first + 16].reshape(4, 4))


def test_level_0_keeps_the_bytes_of_an_image_that_fits():
    pixels = np.random.default_rng(0).integers(0, 256, (256, 256, 4)).astype(np.uint8)
    assert np.array_equal(mip_chain(Image(pixels), 256, True)[0], pixels)


def box_average(values: np.ndarray, size: int) -> np.ndarray:
    """float64 (size, size, 4) means over equal squares of `values`."""
    block = values.shape[0] // size
    return values.reshape(size, block, size, block, -1).mean(axis=(1, 3))


@pytest.mark.parametrize("srgb", [True, False])
def test_levels_are_averages_in_linear_light(srgb):
    """Alpha is never sRGB. One code of 8 bits, since encoding rounds."""
    pixels = np.random.default_rng(1).integers(0, 256, (256, 256, 4)).astype(np.uint8)
    linear = pixels / 255.0
    if srgb:
        linear[..., :3] = srgb_decode(linear[..., :3])
    for level in mip_chain(Image(pixels), 256, srgb)[1:]:
        mean = box_average(linear, len(level))
        expected = np.concatenate([srgb_encode(mean[..., :3]), mean[..., 3:]], axis=-1) if srgb else mean
        assert np.abs(level - expected * 255).max() <= 1.0
    assert np.abs(mip_chain(Image(pixels), 256, srgb)[-1] - expected * 255).max() <= 0.51


def test_black_and_white_average():
    """Half black, half white: 188 in sRGB (linear 0.5), 128 in linear images."""
    checker = np.zeros((256, 256, 4), np.uint8)
    checker[::2, ::2] = checker[1::2, 1::2] = 255
    assert mip_chain(Image(checker), 256, True)[1][0, 0].tolist() == [188, 188, 188, 128]
    assert mip_chain(Image(checker), 256, False)[1][0, 0].tolist() == [128] * 4


def test_resizing_keeps_the_image_in_place():
    """A ramp of 64 pixels becomes one of 256: left stays left, and up stays up."""
    ramp = np.zeros((64, 64, 4), np.uint8)
    ramp[..., 0], ramp[..., 1] = np.arange(64)[None, :] * 4, np.arange(64)[:, None] * 4
    level = mip_chain(Image(ramp), 256, False)[0].astype(int)
    inner = slice(8, -8)  # the resampler's support at the rim
    expected = (np.arange(256) + 0.5) / 4 * 4 - 2
    assert np.abs(level[128, inner, 0] - expected[inner]).max() <= 1
    assert np.abs(level[inner, 128, 1] - expected[inner]).max() <= 1
