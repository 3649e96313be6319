"""KHR_texture_basisu: pictures of both codecs, broken ones, and what happens without the decoder."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from compressed import error_of, outcomes

from octolux.scene.gltf import basisu as gltf_basisu
from octolux.scene.gltf.loader import load_gltf

DATA = Path(__file__).parent / "data"
needs_decoder = pytest.mark.skipif(not gltf_basisu.is_available(), reason="opengl-basisu has no wheel for this system")


def basis_model(gltf, data: bytes | None, required: bool = True, source: int | None = None) -> None:
    gltf.triangle()
    if data is not None:
        (gltf.folder / "picture.ktx2").write_bytes(data)
    texture = {"extensions": {"KHR_texture_basisu": {"source": 0}}} | ({} if source is None else {"source": source})
    gltf.json |= {
        "images": [{"uri": "picture.ktx2", "mimeType": "image/ktx2"}, {"uri": "plain.png"}],
        "textures": [texture],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "extensionsUsed": ["KHR_texture_basisu"],
    }
    if required:
        gltf.json["extensionsRequired"] = ["KHR_texture_basisu"]


@needs_decoder
@pytest.mark.covers(
    "glTF KHR_texture_basisu",
    "image KTX2",
    files=[f"tests/scene/data/{name}.ktx2" for name in ("etc1s", "uastc", "uastc-zstd")],
)
@pytest.mark.parametrize("name", ["etc1s", "uastc", "uastc-zstd"])
def test_basis(gltf, name):
    """Pictures of 8 x 12: red, green and half transparent blue stripes, the right half darker."""
    basis_model(gltf, (DATA / f"{name}.ktx2").read_bytes())
    image = load_gltf(gltf.write()).materials[0].base_color_texture.image
    assert image.size == (8, 12)
    expected = [[(200, 40, 40, 255), (100, 20, 20, 255)], [(40, 200, 40, 255), (20, 100, 20, 255)]]
    expected.append([(40, 40, 200, 128), (20, 20, 100, 128)])
    # ETC1S has five bits for a block's colour and shares colours among blocks.
    tolerance = 255 / 31 if name == "etc1s" else 1
    np.testing.assert_allclose(image.pixels[1::4, 1::4].astype(int), expected, atol=tolerance)


@pytest.mark.covers("glTF KHR_texture_basisu", "image KTX2", broken=True)
@needs_decoder
@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda data: b"", "does not begin"),
        (lambda data: data[:90], "does not begin"),
        (lambda data: data[:-40], "no readable"),
        (lambda data: b"\x89PNG" + data[4:], "does not begin"),
        (lambda data: data[:20] + struct.pack("<2I", 60000, 60000) + data[28:], "more than"),
        (lambda data: data[:20] + struct.pack("<2I", 0, 12) + data[28:], "two dimensions"),
        (lambda data: data[:36] + struct.pack("<I", 6) + data[40:], "two dimensions"),
        (lambda data: data[:88] + struct.pack("<Q", 2**40) + data[96:], "within its pixels"),
        (lambda data: data[:96] + struct.pack("<Q", 2**40) + data[104:], "too many"),
        (lambda data: data[:44] + struct.pack("<I", 99) + data[48:], "no readable"),
    ],
)
def test_broken_basis(gltf, change, problem):
    basis_model(gltf, change((DATA / "uastc-zstd.ktx2").read_bytes()))
    error = error_of(gltf.write())
    assert error.place == "image 0"
    assert problem in error.problem


@pytest.mark.covers("glTF KHR_texture_basisu", "image KTX2", broken=True)
@needs_decoder
def test_missing_basis_picture(gltf):
    basis_model(gltf, None)
    scene = load_gltf(gltf.write())
    assert tuple(scene.materials[0].base_color_texture.image.pixels[0, 0]) == (255, 0, 255, 255)
    assert "picture.ktx2 is missing" in scene.warnings[0]


@pytest.mark.covers("glTF KHR_texture_basisu")
def test_basis_without_its_decoder(gltf, picture, monkeypatch):
    monkeypatch.setattr(gltf_basisu, "opengl_basisu", None)
    picture("plain.png", (1, 2, 3))
    basis_model(gltf, b"", required=False, source=1)
    scene = load_gltf(gltf.write())
    assert tuple(scene.materials[0].base_color_texture.image.pixels[0, 0]) == (1, 2, 3, 255)
    assert scene.warnings == ["texture 0: KHR_texture_basisu needs the package opengl-basisu; its plain image is taken"]
    del gltf.json["textures"][0]["source"]
    assert "opengl-basisu" in error_of(gltf.write()).remedy


@pytest.mark.covers("glTF KHR_texture_basisu", "image KTX2", broken=True)
@needs_decoder
@pytest.mark.parametrize("name", ["etc1s", "uastc-zstd"])
def test_mutated_basis(gltf, name):
    data = (DATA / f"{name}.ktx2").read_bytes()
    basis_model(gltf, data)
    loaded, refused = outcomes(gltf.write(), gltf.folder / "picture.ktx2", slice(0, len(data)))
    assert loaded + refused == 400
    assert refused
