"""`octolux render`: what it writes is what a Picture holds, and says what it cost."""

from __future__ import annotations

import json
import os
import stat
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

import octolux
from octolux.frame.frame import FrameSettings
from octolux.techniques import TECHNIQUES, technique_class

SIZE = (16, 12)
FRAME = FrameSettings(*SIZE, shadow_resolution=64, rsm_resolution=16)
LAYERS = {  # docs/conventions.md: EXR layers
    "direct": "RGB", "indirect": "RGB", "irradiance": "RGB", "specular": "RGB", "emissive": "RGB", "albedo": "RGB",
    "normal": "XYZ", "position": "XYZ", "motion": "XY", "depth": "", "object_id": "", "noise": "",
    "fog": "RGB", "transmittance": "RGB",
}  # fmt: skip


def picture_of(device, scene, technique="uniform-lpv", camera=None, **settings) -> octolux.Picture:
    """The same picture through the Python interface."""
    chosen = technique_class(technique).settings_class(**settings)
    loaded = octolux.load(scene) if isinstance(scene, str) else scene
    renderer = octolux.Renderer(
        loaded, technique, settings=chosen, size=SIZE, device=device, frame_settings=FRAME
    )
    return renderer.render(camera)


def exr_channels(path: Path) -> dict[str, np.ndarray]:
    return {name: c.pixels for name, c in OpenEXR.File(str(path), separate_channels=True).channels().items()}


def png(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path))


UNIFORM = ("--technique", "uniform-lpv")


def test_png_exr_and_statistics(render, folder, device):
    done = render("cornell-box", *UNIFORM, "--set", "n=16", "--out", "a.png", "--out", "a.exr", "--stats", "a.json")
    assert done.code == 0, done.err
    assert sorted(p.name for p in folder.iterdir()) == ["a.exr", "a.json", "a.png"]
    picture = picture_of(device, "cornell-box", n=16)
    check_png(folder / "a.png", picture)
    check_exr(folder / "a.exr", picture)
    statistics = json.loads((folder / "a.json").read_text())
    check_statistics(statistics, picture)
    for word in ("uniform-lpv", "16x12", statistics["adapter"], "frame", *(s["name"] for s in statistics["stages"])):
        assert word in done.out


def check_png(path: Path, picture: octolux.Picture) -> None:
    assert Image.open(path).mode == "RGB"
    np.testing.assert_array_equal(png(path), picture.display[..., :3])
    permissions = stat.S_IMODE(path.stat().st_mode)
    umask = os.umask(0)
    os.umask(umask)
    assert permissions == 0o666 & ~umask


def check_exr(path: Path, picture: octolux.Picture) -> None:
    channels = exr_channels(path)
    expected = {c: picture.radiance[..., i] for i, c in enumerate("RGB")} | {"A": picture.alpha}
    for layer, suffixes in LAYERS.items():
        data = picture.layers[layer]
        expected |= {f"{layer}.{s}": data[..., i] for i, s in enumerate(suffixes)} if suffixes else {layer: data}
    assert channels.keys() == expected.keys()
    for name, values in expected.items():
        assert channels[name].dtype == (np.uint32 if name == "object_id" else np.float32), name
        np.testing.assert_array_equal(channels[name], values, err_msg=name)
    assert channels["irradiance.R"].max() > 0
    assert channels["object_id"].max() == 5  # the fifth of the box's instances


def check_statistics(statistics: dict, picture: octolux.Picture) -> None:
    assert list(statistics) == [
        "adapter", "technique", "settings", "frame_settings", "size", "samples", "frames", "frame_ms", "stages",
        "timing", "timing_note", "pools", "memory_bytes", "energy",
    ]  # fmt: skip
    assert statistics["technique"] == "uniform-lpv"
    assert statistics["settings"] == TECHNIQUES["uniform-lpv"].settings_class(n=16).as_dict()
    assert (statistics["size"], statistics["frames"]) == (list(SIZE), 1)
    assert list(statistics["frame_ms"]) == ["mean", "median", "min", "max"]
    for stage in statistics["stages"]:
        assert list(stage) == ["name", "count", "mean_ms", "median_ms", "total_ms"]
    memory = statistics["memory_bytes"]
    assert memory["total"] == sum(v for k, v in memory.items() if k != "total")
    assert statistics["energy"] == picture.energy
    assert list(picture.energy) == ["direct_mean", "indirect_mean"]


def test_frames_move_with_the_keyframes(render, folder, device):
    """The last of two frames at 1 frame a second shows the scene at 1 s, and each stage ran twice."""
    done = render(
        "cornell-box", "--technique", "none", "--frames", "2", "--fps", "1", "--out", "b.png", "--stats", "b.json"
    )
    assert done.code == 0, done.err
    statistics = json.loads((folder / "b.json").read_text())
    assert statistics["frames"] == 2
    assert {stage["count"] for stage in statistics["stages"]} == {2}
    later = picture_of(device, octolux.load("cornell-box").at(1.0), "none")
    np.testing.assert_array_equal(png(folder / "b.png"), later.display[..., :3])
    assert statistics["energy"] == later.energy


def test_camera_by_name_and_index(render, folder, two_cameras, device):
    for camera, file in (("red wall", "name.png"), ("1", "index.png")):
        done = render(str(two_cameras), "--technique", "none", "--camera", camera, "--out", file)
        assert done.code == 0, done.err
    assert (folder / "name.png").read_bytes() == (folder / "index.png").read_bytes()
    scene = octolux.load(two_cameras)
    np.testing.assert_array_equal(png(folder / "name.png"), picture_of(device, scene, "none", 1).display[..., :3])
    assert not np.array_equal(picture_of(device, scene, "none").display, picture_of(device, scene, "none", 1).display)


def test_preset_and_settings(render, folder):
    """--set wins over --preset, and texts become numbers and truth values."""
    changes = ("--preset", "paper", "--set", "n=16", "--set", "damping=false")
    done = render("cornell-box", *UNIFORM, *changes, "--stats", "p.json")
    assert done.code == 0, done.err
    settings_class = TECHNIQUES["uniform-lpv"].settings_class
    expected = settings_class(**{**settings_class.PRESETS["paper"], "n": 16, "damping": False})
    assert json.loads((folder / "p.json").read_text())["settings"] == expected.as_dict()
    assert (folder / "octolux.png").is_file()  # where the picture goes without --out


def test_baselines(render, folder):
    """`none` has no indirect light; `constant` has the irradiance it was given, everywhere."""
    render("cornell-box", "--technique", "none", "--out", "none.exr")
    render("cornell-box", "--technique", "constant", "--set", "red=2", "--set", "blue=0", "--out", "constant.exr")
    none, constant = exr_channels(folder / "none.exr"), exr_channels(folder / "constant.exr")
    assert not any(none[f"indirect.{c}"].any() for c in "RGB")
    seen = constant["depth"] > 0
    for channel, value in (("R", 2.0), ("G", 1.0), ("B", 0.0)):
        np.testing.assert_array_equal(constant[f"irradiance.{channel}"][seen], np.float32(value))
        np.testing.assert_allclose(
            constant[f"indirect.{channel}"], constant[f"albedo.{channel}"] * (value / np.pi), rtol=1e-6
        )
        np.testing.assert_array_equal(constant[f"direct.{channel}"], none[f"direct.{channel}"])


@pytest.mark.parametrize(
    ("words", "settings"),
    [
        (("--no-normal-maps",), {"normal_maps": False}),
        (("--shadow-filter", "1"), {"shadow_filter": 1}),
        (("--no-inverse-square",), {"inverse_square": False}),
        (("--normal-maps", "--shadow-filter", "2", "--inverse-square"), {}),
    ],
)
def test_settings_that_all_techniques_share(render, folder, device, words, settings):
    """The picture of a renderer that has them, and told of in the header."""
    done = render("corridor", "--technique", "none", "--exposure", "8", *words, "--out", "a.exr")
    assert done.code == 0, done.err
    frame = replace(FRAME, **settings)
    found = octolux.Renderer(octolux.load("corridor"), "none", size=SIZE, device=device, frame_settings=frame).render()
    channels = exr_channels(folder / "a.exr")
    for layer in ("normal", "direct"):
        for c, name in enumerate(LAYERS[layer]):
            np.testing.assert_array_equal(channels[f"{layer}.{name}"], found.layers[layer][..., c])
    assert json.loads(OpenEXR.File(str(folder / "a.exr")).header()["frame_settings"]) == vars(frame)


def test_exposure(render, folder, device):
    """A stop more in EV100 is half the light in the picture for display, and the same light in nits."""
    for ev in ("2", "3"):
        render("furnace", "--technique", "none", "--exposure", ev, "--out", f"{ev}.png", "--out", f"{ev}.exr")
    assert exr_channels(folder / "2.exr")["R"].max() == exr_channels(folder / "3.exr")["R"].max()

    def linear(path: Path) -> float:
        code = float(np.median(png(path))) / 255
        return ((code + 0.055) / 1.055) ** 2.4

    # The tone map takes 0.04 off all that is not dark (Khronos PBR neutral); a code is within 1/255 of its value.
    assert linear(folder / "2.png") + 0.04 == pytest.approx(2 * (linear(folder / "3.png") + 0.04), rel=0.02)
