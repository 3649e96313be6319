"""Decoding of images."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from PIL import Image as Pillow

from octolux.scene.errors import SceneError
from octolux.scene.images import load_image


def test_row_zero_is_at_the_top_and_alpha_is_kept(picture):
    pixels = np.arange(2 * 3 * 4, dtype=np.uint8).reshape(2, 3, 4)
    np.testing.assert_array_equal(load_image(picture("a.png", pixels), "a").pixels, pixels)


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


@pytest.mark.parametrize("data", [b"", b"rubbish", b"%!PS-Adobe-3.0 EPSF-3.0\n", bomb(64), bomb(9000), bomb(60000)])
@pytest.mark.filterwarnings("ignore::PIL.Image.DecompressionBombWarning")
def test_broken_pictures_and_bombs(data):
    with pytest.raises(SceneError) as caught:
        load_image(data, "the picture")
    assert "the picture" in str(caught.value)


def test_cut_off_file(picture):
    whole = picture("a.png", np.random.default_rng(3).integers(0, 255, (64, 64, 3))).read_bytes()
    with pytest.raises(SceneError):
        load_image(whole[: len(whole) // 2], "cut")


def test_missing_file_is_left_to_the_caller(tmp_path):
    with pytest.raises(FileNotFoundError):
        load_image(tmp_path / "none.png", "none")
