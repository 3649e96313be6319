"""Files hold what the Picture holds: 8 and 16 bits, alpha, all layers, and what the header says of them."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import OpenEXR
import pytest
from PIL import Image

import octolux
from octolux.frame.frame import FrameSettings
from octolux.output import complete, write_picture
from octolux.output.options import LAYERS, FileOptions, channel_names
from octolux.techniques import TECHNIQUES

SIZE = (64, 36)


@pytest.fixture(scope="module")
def picture(device) -> octolux.Picture:
    """The Cornell box from afar: surfaces, nothing around them, and edges that are both."""
    scene = octolux.load("cornell-box")
    frame = FrameSettings(*SIZE, shadow_resolution=64, rsm_resolution=16)
    renderer = octolux.Renderer(scene, "none", size=SIZE, device=device, frame_settings=frame, anti_aliasing=4)
    return renderer.render(octolux.Camera.look_at((0.0, 1.0, 9.0), (0.0, 1.0, 0.0)))


def decoded(path: Path, layout: str) -> np.ndarray:
    """By FFmpeg, which wrote none of it; Pillow reads no 16-bit colour."""
    with av.open(str(path)) as container:
        return next(container.decode(video=0)).to_ndarray(format=layout)


@pytest.mark.covers("output .png")
def test_png(picture, folder):
    write_picture(picture, folder / "a.png")
    np.testing.assert_array_equal(decoded(folder / "a.png", "rgb24"), picture.display[..., :3])


@pytest.mark.covers("output .png of 16 bits")
def test_png_of_16_bits(picture, folder):
    options = FileOptions(bits=16)
    write_picture(picture, folder / "a.png", options)
    found = decoded(folder / "a.png", "rgb48le")
    np.testing.assert_array_equal(found, picture.display16()[..., :3])
    assert len(np.unique(found)) > 256  # more than 8 bits hold
    # The same signal in both, rounded once each: half a code of 8 bits apart, and float32 on the device.
    assert np.abs(found / 257 - picture.display[..., :3]).max() <= 0.5 + 1e-2
    assert complete(folder / "a.png", SIZE, options)
    assert not complete(folder / "a.png", SIZE, FileOptions())


@pytest.mark.covers("output .png with alpha")
@pytest.mark.parametrize(("bits", "layout", "top"), [(8, "rgba", 255), (16, "rgba64le", 65535)])
def test_png_with_alpha(picture, folder, bits, layout, top):
    options = FileOptions(bits=bits, alpha=True)
    write_picture(picture, folder / "a.png", options)
    found = decoded(folder / "a.png", layout)
    np.testing.assert_array_equal(found, picture.cutout(bits))
    np.testing.assert_allclose(found[..., 3] / top, picture.alpha, atol=0.5 / top + 1e-7)
    assert {0, top} < set(np.unique(found[..., 3]))  # and edges between
    assert complete(folder / "a.png", SIZE, options)
    assert not complete(folder / "a.png", SIZE, FileOptions(bits=bits))


@pytest.mark.covers("output .exr")
def test_exr_header(picture, folder):
    about = {"technique": "none", "frame": 7, "framesPerSecond": Fraction(24000, 1001), "scene": "Kästchen"}
    write_picture(picture, folder / "a.exr", FileOptions(metadata=about))
    header = OpenEXR.File(str(folder / "a.exr")).header()
    assert {key: header[key] for key in about} == about
    assert header["exposure_ev100"] == pytest.approx(picture.exposure, rel=1e-7)  # float32
    names = {int(number): name for number, name in json.loads(header["object_names"]).items()}
    assert names == picture.object_names
    ids = OpenEXR.File(str(folder / "a.exr"), separate_channels=True).channels()["object_id"].pixels
    seen = {names[number] for number in np.unique(ids[ids > 0])}
    assert {"shell", "left wall", "right wall"} <= seen


@pytest.mark.covers("output .exr")
def test_header_of_a_sequence(run, folder):
    """What made the frame can be read back from it."""
    done = run(
        "render", "cornell-box", "--technique", "constant", "--set", "red=2", "--size", "64x36", "--frames", "3..3",
        "--fps", "12.5", "--exposure", "3.5", "--out", "f_##.exr",
    )  # fmt: skip
    assert done.code == 0, done.err
    header = OpenEXR.File("f_03.exr").header()
    assert header["software"] == f"octolux {octolux.__version__}"
    assert (header["scene"], header["camera"], header["technique"]) == ("cornell-box", "front", "constant")
    assert json.loads(header["settings"]) == TECHNIQUES["constant"].settings_class(red=2.0).as_dict()
    assert (header["frame"], header["framesPerSecond"], header["exposure_ev100"]) == (3, Fraction(25, 2), 3.5)
    assert header["adapter"] in done.out


@pytest.mark.covers("output .exr", "output .npz")
def test_layers_of_exr_and_npz(picture, folder):
    """The declared layers are those a Picture has; some of them on demand."""
    assert set(LAYERS) == set(picture.layers)
    some = FileOptions(layers=("normal", "alpha", "object_id"))
    for name, options in (("all", FileOptions()), ("some", some)):
        wanted = [layer for layer in LAYERS if options.wants(layer)]
        for kind in ("exr", "npz"):
            path = folder / f"{name}.{kind}"
            write_picture(picture, path, options)
            assert complete(path, SIZE, options)
            assert not complete(path, SIZE[::-1], options)
            assert complete(path, SIZE, FileOptions()) == (name == "all")
        channels = OpenEXR.File(str(folder / f"{name}.exr"), separate_channels=True).channels()
        assert set(channels) == {channel for layer in wanted for channel in channel_names(layer)}
        with np.load(folder / f"{name}.npz") as layers:
            assert sorted(layers) == sorted(wanted)
            for layer in wanted:
                np.testing.assert_array_equal(layers[layer], picture.layers[layer])
                assert layers[layer].dtype == picture.layers[layer].dtype


def test_channels():
    assert channel_names("radiance") == ["R", "G", "B"]
    assert channel_names("alpha") == ["A"]
    assert channel_names("motion") == ["motion.X", "motion.Y"]
    assert channel_names("depth") == ["depth"]


@pytest.mark.covers("output .exr", "output .npz", "output .png")
def test_save_from_python(picture, folder):
    """As Picture.save has it: no options, and a header all the same."""
    picture.save(folder / "a.exr")
    picture.save("a.npz")
    assert json.loads(OpenEXR.File("a.exr").header()["object_names"])
    with np.load("a.npz") as layers:
        assert layers["radiance"].shape == (36, 64, 3)
    picture.save("a.png")
    assert Image.open("a.png").size == SIZE


def test_techniques_as_json(run):
    """Every setting with what its declaration says."""
    listed = json.loads(run("techniques", "--json").out)
    assert [one["name"] for one in listed] == list(TECHNIQUES)
    for one in listed:
        settings_class = TECHNIQUES[one["name"]].settings_class
        assert {s["name"]: s["default"] for s in one["settings"]} == settings_class().as_dict()
        assert one["presets"] == {"default": {}, **settings_class.PRESETS}
        for setting in one["settings"]:
            assert setting["meaning"]
            assert setting["cost"]
            assert setting["source"]
            assert set(setting["allowed"]) in ({"one_of"}, {"from", "to"}, {"form"})
