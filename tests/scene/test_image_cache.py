"""The cache of processed textures: what is kept, what is found damaged, and what happens without it."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

from octolux.gpu_scene.mipmaps import mip_chain
from octolux.scene.errors import SceneError
from octolux.scene.images import cache as image_cache
from octolux.scene.images.decode import load_image
from octolux.scene.obj.loader import load_obj


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("OCTOLUX_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def texture(picture):
    return picture("texture.png", np.random.default_rng(2).integers(0, 256, (256, 256, 4)))


def decoded(image) -> bool:
    return "pixels" in vars(image)


def same(a, b) -> bool:
    return len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("srgb", [True, False])
@pytest.mark.parametrize("size", [256, 512])
def test_a_second_load_neither_decodes_nor_filters(cache, texture, size, srgb):
    first = load_image(texture, "t")
    assert decoded(first)
    chain = mip_chain(first, size, srgb)
    second = load_image(texture, "t")
    again = mip_chain(second, size, srgb)
    assert same(chain, again)
    assert not decoded(second)
    assert second.size == (256, 256) and np.array_equal(second.pixels, first.pixels)


def test_sizes_and_colour_spaces_are_kept_apart(cache, texture):
    image = load_image(texture, "t")
    chains = [mip_chain(image, size, srgb) for size in (256, 512) for srgb in (True, False)]
    assert len(list(cache.glob("*.mips"))) == 4
    again = [mip_chain(load_image(texture, "t"), size, srgb) for size in (256, 512) for srgb in (True, False)]
    assert all(same(a, b) for a, b in zip(chains, again, strict=True))


def test_another_file_of_the_same_name_is_another_texture(cache, picture):
    for color in [(1, 2, 3), (4, 5, 6)]:
        image = load_image(picture("a.png", color), "a")
        assert mip_chain(image, 256, True)[-1][0, 0, :3].tolist() == list(color)


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "longer", "other"])
def test_damaged_files_are_made_anew(cache, texture, damage):
    chain = mip_chain(load_image(texture, "t"), 256, True)
    (path,) = cache.glob("*.mips")
    whole = path.read_bytes()
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    path.write_bytes({"cut": whole[:-1], "flipped": bytes(flipped), "empty": b"", "longer": whole + b"x",
                      "other": os.urandom(len(whole))}[damage])  # fmt: skip
    assert same(mip_chain(load_image(texture, "t"), 256, True), chain)
    assert path.read_bytes() == whole


def test_deleting_everything_at_any_time(cache, texture):
    chain = mip_chain(load_image(texture, "t"), 256, True)
    image = load_image(texture, "t")
    for path in cache.iterdir():
        path.unlink()
    cache.rmdir()
    assert same(mip_chain(image, 256, True), chain)


def test_broken_pictures_are_found_at_each_load(cache, texture):
    whole = texture.read_bytes()
    texture.write_bytes(whole[: len(whole) // 2])
    for _ in range(2):
        with pytest.raises(SceneError):
            load_image(texture, "t")
    assert not list(cache.glob("*")) if cache.exists() else True


def test_off_and_a_folder_that_cannot_be(tmp_path, monkeypatch, texture):
    monkeypatch.setenv("OCTOLUX_CACHE", "off")
    plain = mip_chain(load_image(texture, "t"), 256, True)
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("OCTOLUX_CACHE", str(tmp_path / "file" / "cache"))
    image = load_image(texture, "t")
    assert same(mip_chain(image, 256, True), plain)
    assert decoded(load_image(texture, "t"))


def test_images_that_are_no_files_are_not_kept(cache):
    from octolux.scene.materials import Image

    mip_chain(Image(np.zeros((256, 256, 4), np.uint8)), 256, True)
    assert not cache.exists()


def test_masks_and_normals_of_obj_are_kept_too(cache, tmp_path, picture):
    picture("color.png", np.random.default_rng(1).integers(0, 256, (64, 64, 3)))
    picture("mask.png", np.random.default_rng(2).integers(0, 256, (64, 64)))
    picture("bump.png", np.random.default_rng(3).integers(0, 256, (64, 64)))
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd color.png\nmap_d mask.png\nbump -bm 2 bump.png\n")
    (tmp_path / "m.obj").write_text("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n")

    def images():
        material = load_obj(tmp_path / "m.obj").materials[0]
        return material.base_color_texture.image, material.normal_texture.image

    first = [mip_chain(image, 256, True) for image in images()]
    found = images()
    assert all(same(mip_chain(image, 256, True), chain) for image, chain in zip(found, first, strict=True))
    assert not any(decoded(image) for image in found)
    before = len(list(cache.glob("*.mips")))
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd color.png\nmap_d mask.png\nbump -bm 3 bump.png\n")
    assert not same(mip_chain(images()[1], 256, True), first[1])
    assert len(list(cache.glob("*.mips"))) == before + 1


def test_many_writers_of_one_file(cache):
    """Every reader meets the whole of one writer's data, or nothing."""
    datas = [bytes([n]) * 100_000 for n in range(8)]
    threads = [threading.Thread(target=image_cache.write, args=("name", data)) for data in datas for _ in range(4)]
    for thread in threads:
        thread.start()
        found = image_cache.read("name", 100_000)
        assert found is None or bytes(found) in datas
    for thread in threads:
        thread.join()
    assert bytes(image_cache.read("name", 100_000)) in datas
    assert [path.name for path in cache.iterdir()] == ["name"]


def test_the_oldest_go_first(cache):
    for number in range(4):
        image_cache.write(str(number), bytes(1000))
        os.utime(cache / str(number), ns=(0, 10**9 * (number + 1)))
    image_cache.read("0", 1000)  # used now, so no longer the oldest
    size = (cache / "0").stat().st_size
    image_cache.trim(cache, 2 * size)
    assert sorted(path.name for path in cache.iterdir()) == ["0", "3"]


def test_writing_keeps_the_bound(cache, monkeypatch):
    monkeypatch.setattr(image_cache, "_written", 0)
    monkeypatch.setattr(image_cache, "_TRIM_AFTER", 3000)
    trimmed = []
    monkeypatch.setattr(image_cache, "trim", trimmed.append)
    for number in range(7):
        image_cache.write(str(number), bytes(1000))
    assert trimmed == [cache, cache]


def test_keys():
    assert image_cache.content_key("ab", b"c") != image_cache.content_key("a", b"bc")
    assert image_cache.content_key("a", "") == ""
