"""References from files: what is read, and what is refused in one line."""

from __future__ import annotations

import json

import numpy as np
import OpenEXR
import pytest
from comparisons import SIZE
from gpu_tools import small_settings

import octolux
from octolux.compare import compare
from octolux.compare.reference_files import read_reference
from octolux.data import data_folder
from octolux.output import write_picture
from octolux.output.options import FileOptions
from octolux.scene.errors import OctoluxError

WIDTH, HEIGHT = SIZE


@pytest.fixture(scope="module")
def picture(device) -> octolux.Picture:
    scene = octolux.load("cornell-box")
    return octolux.Renderer(scene, "constant", size=SIZE, device=device, frame_settings=small_settings()).render()


def by_light_paths(**changes) -> dict[str, np.ndarray]:
    """The arrays of a path tracer's file, with made-up light."""
    rng = np.random.default_rng(3)
    paths = ("first_bounce", "all_indirect")
    light = {name: rng.random((HEIGHT, WIDTH, 3)).astype(np.float32) for name in ("direct", *paths)}
    halves = {f"seed{seed}_{name}": light[name] + noise for seed, noise in (("A", 0.1), ("B", -0.1)) for name in paths}
    full = {"full": light["direct"] + light["all_indirect"]}
    return {**light, **halves, **full, "mask": np.ones((HEIGHT, WIDTH), bool)} | changes


@pytest.mark.parametrize("suffix", [".exr", ".npz"])
def test_octoluxs_own_files(picture, tmp_path, suffix):
    picture.save(tmp_path / f"a{suffix}")
    found = read_reference(tmp_path / f"a{suffix}")
    for name, layer in (("final", "radiance"), ("indirect", "indirect"), ("direct", "direct")):
        np.testing.assert_array_equal(found.pictures[name], picture.layers[layer])
    np.testing.assert_array_equal(found.mask, picture.mask)
    assert (found.size, found.noise_free, found.noise("final")) == (SIZE, False, None)


def test_light_paths(tmp_path):
    arrays = by_light_paths()
    np.savez(tmp_path / "a.npz", **arrays)
    every, first = (read_reference(tmp_path / "a.npz", paths) for paths in ("", "first_bounce"))
    np.testing.assert_array_equal(every.pictures["indirect"], arrays["all_indirect"])
    np.testing.assert_array_equal(every.pictures["final"], arrays["full"])
    np.testing.assert_array_equal(first.pictures["indirect"], arrays["first_bounce"])
    np.testing.assert_array_equal(first.pictures["final"], arrays["direct"] + arrays["first_bounce"])
    assert every.noise_free and first.noise_free
    np.testing.assert_array_equal(first.halves["indirect"][0], arrays["seedA_first_bounce"])
    # Halves 0.2 apart: the mean of two is 0.1 off by that measure.
    assert first.noise("indirect") == pytest.approx(0.1 / arrays["first_bounce"].mean(), rel=1e-5)


def test_light_paths_without_halves(tmp_path):
    arrays = {k: v for k, v in by_light_paths().items() if not k.startswith("seed")}
    np.savez(tmp_path / "a.npz", **arrays)
    found = read_reference(tmp_path / "a.npz")
    assert not found.noise_free
    np.testing.assert_array_equal(found.halves["indirect"][1], arrays["all_indirect"])


def test_two_halves_suffice(tmp_path):
    """The picture is then their mean; with halves of other light alone there is still none."""
    arrays = {k: v for k, v in by_light_paths().items() if k in ("direct", "mask") or k.endswith("A_first_bounce")}
    arrays["seedB_first_bounce"] = 3 * arrays["seedA_first_bounce"]
    np.savez(tmp_path / "a.npz", **arrays)
    found = read_reference(tmp_path / "a.npz", "first_bounce")
    np.testing.assert_array_equal(found.pictures["indirect"], 2 * arrays["seedA_first_bounce"])
    np.testing.assert_array_equal(found.pictures["final"], arrays["direct"] + 2 * arrays["seedA_first_bounce"])
    assert found.noise_free
    with pytest.raises(OctoluxError, match="all_indirect"):
        read_reference(tmp_path / "a.npz")


@pytest.mark.parametrize("suffix", [".exr", ".npz"])
def test_broken_files(picture, tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    with pytest.raises(OctoluxError, match="no such file"):
        read_reference(path)
    picture.save(path)
    whole = path.read_bytes()
    for data in (b"", b"nonsense", whole[: len(whole) // 2]):
        path.write_bytes(data)
        with pytest.raises(OctoluxError, match="damaged"):
            read_reference(path)


def test_an_npy_is_no_npz(tmp_path):
    with (tmp_path / "a.npz").open("wb") as file:
        np.save(file, np.zeros((4, 4)))
    with pytest.raises(OctoluxError, match="not an NPZ"):
        read_reference(tmp_path / "a.npz")


def test_missing_layers_are_named(tmp_path):
    layers = {name: np.zeros((HEIGHT, WIDTH), np.float32) for name in "RGB"}
    OpenEXR.File({"type": OpenEXR.scanlineimage}, layers).write(str(tmp_path / "a.exr"))
    with pytest.raises(OctoluxError, match=r"direct, indirect, depth are missing.*octolux render"):
        read_reference(tmp_path / "a.exr")


def wrong(name: str, value: float) -> dict[str, np.ndarray]:
    bad = by_light_paths()[name].copy()
    bad[1, 2, 0] = value
    return {name: bad}


@pytest.mark.parametrize(
    ("changes", "paths", "says"),
    [
        (wrong("direct", np.nan), "", "direct: 1 values are NaN"),
        (wrong("seedB_first_bounce", np.inf), "first_bounce", "seedB_first_bounce: 1 values"),
        ({"mask": np.ones((5, 5), bool)}, "", "shape"),
        ({"direct": np.ones((HEIGHT, WIDTH))}, "", "shape"),
        ({}, "second_bounce", "all_indirect or first_bounce"),
    ],
)  # fmt: skip
def test_wrong_arrays(tmp_path, changes, paths, says):
    np.savez(tmp_path / "a.npz", **by_light_paths(**changes))
    with pytest.raises(OctoluxError, match=says):
        read_reference(tmp_path / "a.npz", paths)


def test_light_paths_of_a_file_that_has_none(picture, tmp_path):
    picture.save(tmp_path / "a.npz")
    with pytest.raises(OctoluxError, match="first_bounce"):
        read_reference(tmp_path / "a.npz", "first_bounce")


def test_the_size_is_the_files(picture, tmp_path, device):
    picture.save(tmp_path / "a.exr")
    settings = {"device": device, "frame_settings": small_settings(), "frames": 1}
    found = compare("cornell-box", ["constant,red=1"], tmp_path / "a.exr", **settings)
    assert found.facts["size"] == list(SIZE)
    assert found.entries[0].metrics["final"]["relative_rmse"] == 0.0
    assert not [note for note in found.facts["notes"] if "places" in note]
    with pytest.raises(OctoluxError, match=rf"{WIDTH}x{HEIGHT} pixels, not 64x36.*--size {WIDTH}x{HEIGHT}"):
        compare("cornell-box", ["none"], tmp_path / "a.exr", size=(64, 36), **settings)
    with pytest.raises(OctoluxError, match="not for a file"):
        compare("cornell-box", ["none"], tmp_path / "a.exr", reference_samples=4, **settings)


def test_another_view_is_noticed(picture, tmp_path, device):
    picture.save(tmp_path / "a.exr")
    settings = {"device": device, "frame_settings": small_settings(), "frames": 1}
    found = compare("two-rooms", ["none"], tmp_path / "a.exr", **settings)
    assert "other places" in found.facts["notes"][0]


@pytest.mark.parametrize("told", [{"normal_maps": False, "shadow_filter": 1}, None], ids=str)
def test_a_reference_of_other_light_is_noticed(picture, tmp_path, device, told):
    """As its header says; a file that does not tell has all as it is by default."""
    about = {"frame_settings": json.dumps(told)} if told else {}
    write_picture(picture, tmp_path / "a.exr", FileOptions(metadata=about))
    found = read_reference(tmp_path / "a.exr").facts
    assert ("frame_settings" in found) == bool(told)
    settings = {"device": device, "frame_settings": small_settings(inverse_square=False), "frames": 1}
    notes = compare("cornell-box", ["none"], tmp_path / "a.exr", **settings).facts["notes"]
    wanted = ["the reference is made with inverse_square=True, the techniques with False"]
    if told:
        wanted.insert(0, "the reference is made with normal_maps=False, the techniques with True")
    assert [note for note in notes if "made with" in note] == wanted


@pytest.mark.skipif(not (data_folder() / "ground-truth").is_dir(), reason="needs OCTOLUX_DATA")
@pytest.mark.parametrize("name", ["cornell_point", "cornell_area", "sponza_sunpoint"])
def test_ground_truth(name):
    """Path-traced files of the data folder: all indirect light is more than its first bounce."""
    path = data_folder() / "ground-truth" / f"{name}.npz"
    every, first = read_reference(path), read_reference(path, "first_bounce")
    assert every.noise_free and every.mask.any()
    assert every.pictures["indirect"].mean() > first.pictures["indirect"].mean() > 0.0
