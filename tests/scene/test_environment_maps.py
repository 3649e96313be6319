"""Pictures of the surroundings, and the [environment] table of TOML scenes."""

from __future__ import annotations

from math import radians
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.images.environment_maps import load_environment_map
from octolux.scene.images.radiance_hdr import HdrFault, read_hdr
from octolux.simulator.tonemap import srgb_decode

HEAD = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"


def rgbe(colors: np.ndarray) -> np.ndarray:
    """uint8 (..., 4): Ward's setcolr, a mantissa of 8 bits for each channel and the exponent of the largest."""
    largest = colors.max(axis=-1)
    _, exponent = np.frexp(largest)
    mantissas = np.floor(np.ldexp(colors, (8 - exponent)[..., None]))
    return np.concatenate([mantissas, exponent[..., None] + 128], axis=-1).astype(np.uint8)


def coded(rows: np.ndarray, size: bytes = b"") -> bytes:
    """The rows of rgbe, each channel cut in runs of what is equal and literals of one byte."""
    height, width = rows.shape[:2]
    data = HEAD + b"\n" + (size or b"-Y %d +X %d" % (height, width)) + b"\n"
    for row in rows:
        data += bytes((2, 2, width >> 8, width & 255))
        for channel in row.T:
            data += b"".join(_runs(channel))
    return data


def _runs(channel: np.ndarray):
    start = 0
    while start < len(channel):
        run = 1
        while run < 127 and start + run < len(channel) and channel[start + run] == channel[start]:
            run += 1
        yield bytes((128 + run, channel[start])) if run > 2 else bytes((run, *channel[start : start + run]))
        start += run


@pytest.fixture
def colors() -> np.ndarray:
    generator = np.random.default_rng(5)
    found = generator.uniform(0.1, 1, (6, 300, 3)) * 2.0 ** generator.integers(-20, 20, (6, 300, 1))
    found[2, 20:200] = found[2, 20]  # runs longer than one may be
    return found


@pytest.mark.covers("environment .hdr")
def test_rgbe_within_half_a_step(colors):
    """Mantissas are cut to 8 bits, of which the largest of a pixel uses all; the reader adds half a step."""
    for data in (coded(rgbe(colors)), HEAD + b"\n-Y 6 +X 300\n" + rgbe(colors).tobytes()):
        found = read_hdr(data, 10**6)
        assert found.dtype == np.float32
        step = 2.0 ** (np.frexp(colors.max(axis=-1, keepdims=True))[1] - 8)
        assert (np.abs(found - colors) <= 0.5 * step * (1 + 1e-6)).all()


@pytest.mark.covers("environment .hdr")
def test_black_exposure_and_orientation(colors):
    pixels = rgbe(colors)
    pixels[0, 0] = 0
    plain = read_hdr(coded(pixels), 10**6)
    assert (plain[0, 0] == 0).all()
    brighter = coded(pixels).replace(b"FORMAT", b"EXPOSURE=4\nEXPOSURE=0.5\nFORMAT")
    np.testing.assert_allclose(read_hdr(brighter, 10**6), plain / 2, rtol=1e-6)
    turned = read_hdr(coded(pixels, b"+Y 6 -X 300"), 10**6)
    np.testing.assert_array_equal(turned, plain[::-1, ::-1])


@pytest.mark.covers("environment .pic")
def test_pic_is_radiance_too(tmp_path, colors):
    """Radiance's own programs name such files .pic."""
    (tmp_path / "a.pic").write_bytes(coded(rgbe(colors)))
    found, warnings = load(tmp_path / "a.pic")
    np.testing.assert_array_equal(found, read_hdr(coded(rgbe(colors)), 10**6))
    assert not warnings


@pytest.mark.covers("environment .hdr")
def test_xyz_white_is_white():
    """D65, XYZ (0.9505, 1, 1.089), is (1, 1, 1), within the 8 bits of a mantissa: a step is 2^-7 for values above 1."""
    white = np.broadcast_to(np.array([0.9505, 1.0, 1.089]), (1, 8, 3))
    found = read_hdr(coded(rgbe(white)).replace(b"rgbe", b"xyze"), 100)
    # Half a step, times the largest sum of a row's magnitudes.
    assert np.abs(found - 1).max() <= 0.5 * 2**-7 * (3.2406 + 1.5372 + 0.4986) + 1e-3


@pytest.mark.covers("environment .hdr", broken=True)
@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "is no Radiance picture"),
        (b"#?RADIANCE\n", "header does not end"),
        (HEAD + b"\n+X 4 -Y 4\n" + bytes(64), "size"),
        (HEAD + b"\n-Y 99999 +X 99999\n", "99999 x 99999"),
        (HEAD + b"\n-Y 0 +X 5\n", "0 pixels"),
        (HEAD + b"\n-Y 4 +X 4\n" + bytes(60), "cut off"),
        (HEAD + b"\n-Y 8000 +X 16000\n\2\2\x3e\x80" + bytes(100), "cut off"),
        (coded(np.ones((2, 8, 4), np.uint8))[:-3], "cut off"),
        (HEAD + b"EXPOSURE=0\n\n-Y 1 +X 1\n1234", "exposure"),
    ],
)
def test_broken_radiance_pictures(data, text):
    with pytest.raises(HdrFault, match=text):
        read_hdr(data, 16384 * 8192)


def load(path: Path, scale: float = 1.0) -> tuple[np.ndarray, list[str]]:
    warnings: list[str] = []
    return load_environment_map(path, scale, Path("scene.toml"), "[environment]: image", warnings), warnings


@pytest.mark.covers("environment .exr")
@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_openexr(tmp_path, kind):
    pixels = np.random.default_rng(1).uniform(0, 9, (4, 8, 4)).astype(kind)
    OpenEXR.File({}, {"RGBA": pixels}).write(str(tmp_path / "a.exr"))
    found, warnings = load(tmp_path / "a.exr", 2.0)
    np.testing.assert_array_equal(found, pixels[..., :3].astype(np.float32) * 2)
    assert not warnings
    OpenEXR.File({}, {"Y": np.ascontiguousarray(pixels[..., 0])}).write(str(tmp_path / "y.exr"))
    np.testing.assert_array_equal(load(tmp_path / "y.exr")[0], np.repeat(pixels[..., :1].astype(np.float32), 3, axis=2))


@pytest.mark.covers("environment .exr")
def test_texels_that_are_no_radiance_are_clamped_and_counted(tmp_path):
    pixels = np.full((2, 2, 3), 5, np.float32)
    pixels[0, 0, 1], pixels[0, 1, 2], pixels[1, 0] = np.nan, np.inf, -3
    OpenEXR.File({}, {"RGB": pixels}).write(str(tmp_path / "a.exr"))
    found, warnings = load(tmp_path / "a.exr")
    assert found.tolist() == [[[5, 0, 5], [5, 5, 5]], [[0, 0, 0], [5, 5, 5]]]
    assert len(warnings) == 1 and "3 texels" in warnings[0]
    OpenEXR.File({}, {"RGB": pixels * np.float32(np.nan)}).write(str(tmp_path / "b.exr"))
    with pytest.raises(SceneError, match="no finite value"):
        load(tmp_path / "b.exr")


@pytest.mark.covers("environment pictures of 8 bits")
def test_eight_bit_pictures_are_srgb(picture):
    found, _ = load(picture("sky.png", (188, 0, 255)), 100.0)
    np.testing.assert_allclose(found[0, 0], [float(srgb_decode(np.array(188 / 255))) * 100, 0, 100], rtol=1e-6)


@pytest.mark.covers("environment .exr", broken=True)
def test_a_damaged_exr_prints_nothing_beside_the_error(tmp_path, capfd):
    pixels = np.random.default_rng(0).uniform(0, 1, (32, 64, 3)).astype(np.float16)
    OpenEXR.File({}, {"RGB": pixels}).write(str(tmp_path / "a.exr"))
    whole = bytearray((tmp_path / "a.exr").read_bytes())
    whole[len(whole) // 2 : len(whole) // 2 + 8] = bytes(8)
    (tmp_path / "a.exr").write_bytes(whole)
    with pytest.raises(SceneError, match="cannot be read"):
        load(tmp_path / "a.exr")
    assert capfd.readouterr() == ("", "")


@pytest.mark.covers("environment .hdr", "environment .exr", "environment pictures of 8 bits", broken=True)
def test_broken_and_missing_files(tmp_path):
    OpenEXR.File({}, {"Z": np.ones((2, 2), np.float32)}).write(str(tmp_path / "depth.exr"))
    whole = (tmp_path / "depth.exr").read_bytes()
    contents = {"a.exr": b"", "b.exr": whole[:200], "c.exr": whole[:-4], "d.hdr": b"x", "e.png": b"x"}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(SceneError, match=rf"scene.toml: \[environment\]: image: .*{name}' cannot be read"):
            load(tmp_path / name)
    with pytest.raises(SceneError, match="channels Z"):
        load(tmp_path / "depth.exr")
    with pytest.raises(SceneError, match="there is no file"):
        load(tmp_path / "none.hdr")


@pytest.mark.covers("environment .exr", "model .toml")
def test_the_table_of_a_toml_scene(toml, tmp_path, monkeypatch):
    (tmp_path / "scenes").mkdir()
    OpenEXR.File({}, {"RGB": np.full((2, 4, 3), 3, np.float32)}).write(str(tmp_path / "scenes" / "sky.exr"))
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path))
    text = '[environment]\nimage = "NAME"\nscale = 50\nrotate = 90\nradiance = [1, 2, 3]\n'
    for name in ("scenes/sky.exr", "data:sky.exr"):
        environment = toml(text.replace("NAME", name)).environment
        assert (environment.image == 150).all() and environment.image.shape == (2, 4, 3)
        assert environment.rotation == pytest.approx(radians(90))
        assert environment.radiance == (1.0, 2.0, 3.0)


def test_toml_with_a_byte_order_mark(toml):
    assert toml("\ufeffexposure = 3\n").exposure == 3.0
