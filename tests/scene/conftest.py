"""Small files that the tests of the loaders write, and the data folder for those that need real models."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow
from toml_files import load_text, write_model

from octolux.data import data_folder


@pytest.fixture
def scenes() -> Path:
    folder = data_folder() / "scenes"
    if not folder.is_dir():
        pytest.skip("needs OCTOLUX_DATA")
    return folder


@pytest.fixture
def picture(tmp_path):
    """Writes a PNG of one colour or of a given array into tmp_path."""

    def write(name: str, pixels, size=(4, 4)) -> Path:
        array = np.asarray(pixels, dtype=np.uint8)
        if array.ndim == 1:
            array = np.broadcast_to(array, (size[1], size[0], len(array)))
        Pillow.fromarray(np.ascontiguousarray(array)).save(tmp_path / name)
        return tmp_path / name

    return write


@pytest.fixture
def toml(tmp_path, picture):
    """Loads a TOML scene from its text; the model of toml_files.py lies beside it."""
    write_model(tmp_path)
    picture("wood.png", (200, 150, 100))
    return partial(load_text, tmp_path)


class GltfBuilder:
    """A glTF of one buffer: `add` appends an array as buffer view and accessor, `write` saves the file."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.data = b""
        self.json: dict = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, array: np.ndarray, **more) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        entry = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes, **more}
        self.json["bufferViews"].append(entry)
        self.data += array.tobytes()
        return len(self.json["bufferViews"]) - 1

    def add(self, array: np.ndarray, **more) -> int:
        kinds = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
        width = 1 if array.ndim == 1 else array.shape[1]
        entry = {
            "bufferView": self.view(array),
            "componentType": kinds[array.dtype.name],
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[width],
            "count": len(array),
            **more,
        }
        self.json["accessors"].append(entry)
        return len(self.json["accessors"]) - 1

    def triangle(self) -> GltfBuilder:
        """One triangle in the xy plane, shown by one node: accessor 0 positions, 1 indices."""
        positions = self.add(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32))
        indices = self.add(np.array([0, 1, 2], np.uint16))
        self.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}]
        self.json["nodes"] = [{"mesh": 0}]
        return self

    def write(self, name: str = "model.gltf") -> Path:
        if self.data:
            self.json["buffers"] = [{"uri": "model.bin", "byteLength": len(self.data)}]
            (self.folder / "model.bin").write_bytes(self.data)
        (self.folder / name).write_text(json.dumps(self.json))
        return self.folder / name


@pytest.fixture
def gltf(tmp_path) -> GltfBuilder:
    return GltfBuilder(tmp_path)
