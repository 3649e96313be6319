"""Decoding of images, in each format."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image as Pillow

from octolux.scene.errors import SceneError
from octolux.scene.images.decode import FORMATS, load_image


@pytest.mark.covers("image PNG")
def test_row_zero_is_at_the_top_and_alpha_is_kept(picture):
    pixels = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4)
    np.testing.assert_array_equal(load_image(picture("a.png", pixels), "a").pixels, pixels)


@pytest.mark.covers("image PNG")
def test_sixteen_bit_grey_keeps_its_upper_bits():
    stream = io.BytesIO()
    Pillow.fromarray(np.array([[0, 256, 65535]], np.uint16)).save(stream, "PNG")
    pixels = load_image(stream.getvalue(), "grey").pixels
    assert pixels[0].tolist() == [[0, 0, 0, 255], [1, 1, 1, 255], [255, 255, 255, 255]]


def bomb(size: int) -> bytes:
    """A PNG whose header promises size x size pixels."""
    header = b"IHDR" + struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    return b"\x89PNG\r\n\x1a\n" + chunk + struct.pack(">I", 0) + b"IDAT" + struct.pack(">I", zlib.crc32(b"IDAT"))


@pytest.mark.covers("image PNG", broken=True)
@pytest.mark.parametrize("data", [b"", b"rubbish", b"%!PS-Adobe-3.0 EPSF-3.0\n", bomb(64), bomb(9000), bomb(60000)])
@pytest.mark.filterwarnings("ignore::PIL.Image.DecompressionBombWarning")
def test_broken_pictures_and_bombs(data):
    with pytest.raises(SceneError) as caught:
        load_image(data, "the picture")
    assert "the picture" in str(caught.value)


def test_missing_file_is_left_to_the_caller(tmp_path):
    with pytest.raises(FileNotFoundError):
        load_image(tmp_path / "none.png", "none")


# How each format is written: without loss where it can, and in the codings that pictures of it often have.
WRITTEN = [
    ("PNG", {}),
    ("JPEG", {"quality": 100, "subsampling": 0}),
    ("JPEG", {"quality": 100, "subsampling": 0, "progressive": True}),
    ("WEBP", {"lossless": True}),
    ("TGA", {}),
    ("TGA", {"compression": "tga_rle"}),
    ("BMP", {}),
    ("TIFF", {}),
    ("TIFF", {"compression": "tiff_lzw"}),
    ("TIFF", {"compression": "tiff_adobe_deflate"}),
    ("GIF", {}),
    ("DDS", {}),
    ("PPM", {}),
]
SQUARES = np.array([[(200, 40, 40), (40, 200, 40)], [(40, 40, 200), (250, 200, 10)]], np.uint8)
WITH_ALPHA = ("PNG", "WEBP", "TGA", "TIFF", "DDS")


def covering(cases, broken: bool = False) -> list:
    return [pytest.param(*c, marks=pytest.mark.covers(f"image {c[0]}", broken=broken)) for c in cases]


def written(kind: str, options: dict, pixels: np.ndarray) -> bytes:
    stream = io.BytesIO()
    Pillow.fromarray(pixels).save(stream, kind, **options)
    return stream.getvalue()


def test_every_format_is_tested():
    assert {kind for kind, _ in WRITTEN} == set(FORMATS)


@pytest.mark.parametrize(("kind", "options"), covering(WRITTEN))
def test_formats(kind, options):
    """Four squares as large as the blocks of JPEG: only its rounding remains there. At quality 100 that is half a code
    of Y, Cb and Cr each, of which blue takes 0.5 + 1.772 / 2, and half a code of the result: less than 2, so 1."""
    pixels = SQUARES.repeat(8, axis=0).repeat(8, axis=1)
    found = load_image(written(kind, options, pixels), "squares").pixels
    assert found.shape == (16, 16, 4)
    np.testing.assert_allclose(found[..., :3].astype(int), pixels, atol=1 if kind == "JPEG" else 0)
    assert (found[..., 3] == 255).all()


@pytest.mark.parametrize(("kind", "options"), covering(case for case in WRITTEN if case[0] in WITH_ALPHA))
def test_formats_with_alpha(kind, options):
    pixels = np.random.default_rng(4).integers(1, 256, (6, 10, 4), np.uint8)
    np.testing.assert_array_equal(load_image(written(kind, options, pixels), "noise").pixels, pixels)


@pytest.mark.covers("image DDS")
def test_dds_of_compressed_blocks():
    """BC1: two colours of 5, 6 and 5 bits, and two bits a texel, of which 2 is a third of the way from the first."""
    size, coding, use = (124, 0x81007, 4, 4, 8, 0, 1), (32, 4, b"DXT1", *[0] * 5), (0x1000, 0, 0, 0)
    head = struct.pack("<4s7I44x2I4s5I4I4x", b"DDS ", *size, *coding, *use)
    block = struct.pack("<HH4B", 0xF800, 0x001F, 0x00, 0x55, 0xAA, 0xFF)
    found = load_image(head + block, "blocks").pixels
    assert found[:2, 0].tolist() == [[255, 0, 0, 255], [0, 0, 255, 255]]
    assert found[2:, 0].tolist() == [[170, 0, 85, 255], [85, 0, 170, 255]]


@pytest.mark.filterwarnings("ignore::UserWarning")  # of Pillow's TIFF reader, which says more before it gives up
@pytest.mark.parametrize(("kind", "options"), covering(WRITTEN, broken=True))
def test_cut_off_files(kind, options):
    pixels = np.random.default_rng(3).integers(0, 256, (32, 32, 3), np.uint8)
    whole = written(kind, options, pixels)
    for length in (4, 20, len(whole) // 2):
        with pytest.raises(SceneError, match="the cut picture"):
            load_image(whole[:length], "the cut picture")
