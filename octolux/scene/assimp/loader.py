"""The door to assimp: reads a file in a child process, which may crash or hang without taking this one down."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import SceneError
from ..geometry.triangles import usable_uvs

BASE_FLAGS = ("Triangulate", "JoinIdenticalVertices", "SortByPType")
# For a small file; what it holds may grow so much when it is read that a larger file needs more of both. Bytes read a
# second: assimp takes 365 ms for the 22 MB of Crytek Sponza; a twentieth of that speed is slow enough to call it hung.
SECONDS, BYTES_A_SECOND = 15.0, 3e6
# assimp's own data: a corner takes up to 100 bytes in memory beside 10 in a binary file, and twice while it is joined.
MEMORY, MEMORY_PER_BYTE = 1 << 30, 20
_CHILD = Path(__file__).with_name("child.py")


class AssimpRefusal(Exception):
    """assimp's own answer to a file that it does not read. `kind`: RuntimeError, or ValueError when the file holds
    lines or points, which the binding does not pass on."""

    def __init__(self, kind: str, text: str):
        self.kind = kind
        super().__init__(text)


@dataclass(frozen=True)
class Part:
    """Triangles of one material as assimp gives them. positions, normals: float32 (vertices, 3); uvs: float32
    (vertices, k), v up; colors: float32 (vertices, 4); indices: uint32 (triangles, 3); None where the file has none."""

    name: str
    material: int
    positions: np.ndarray
    indices: np.ndarray
    normals: np.ndarray | None
    uvs: np.ndarray | None
    colors: np.ndarray | None

    def image_uvs(self) -> np.ndarray:
        """float32 (vertices, 2), v turned to point down; zeros where the file has none or none that are of use."""
        uvs = np.zeros((len(self.positions), 2), np.float32)
        if self.uvs is None:
            return uvs
        uvs[:, : min(2, self.uvs.shape[1])] = self.uvs[:, :2]
        uvs[:, 1] = 1.0 - uvs[:, 1]
        return usable_uvs(uvs)


@dataclass(frozen=True)
class Placed:
    """A node that shows parts. matrix: float64 (4, 4), to the world."""

    name: str
    matrix: np.ndarray
    parts: tuple[int, ...]


@dataclass(frozen=True)
class Model:
    """What a file holds. materials: assimp's properties by name; textures: for each material, files by assimp's number
    of their kind (aiTextureType)."""

    parts: list[Part]
    placed: list[Placed]
    materials: list[dict[str, Any]]
    textures: list[dict[int, list[str]]]


def import_model(path: Path, extra_flags: tuple[str, ...] = ()) -> Model:
    """Read `path` with assimp, faces cut into triangles and equal vertices joined.

    Raises AssimpRefusal when assimp says what is wrong; SceneError when it crashes, takes longer than SECONDS (more
    for files of many megabytes) or more than MEMORY.
    """
    header, blobs = _run(path, ",".join((*BASE_FLAGS, *extra_flags)))
    if "error" in header:
        raise AssimpRefusal(header["error"], header["text"])
    parts, start = [], 0
    for entry in header["parts"]:
        part, start = _part(entry, blobs, start)
        parts.append(part)
    placed = _placed(header["nodes"])
    last = max((p.material for p in parts), default=-1)
    if last >= len(header["materials"]) or any(n >= len(parts) for p in placed for n in p.parts):
        raise AssimpRefusal("RuntimeError", "it names a mesh or material that is not there")
    textures = [{int(kind): files for kind, files in t.items()} for t in header["textures"]]
    return Model(parts, placed, header["materials"], textures)


def _run(path: Path, flags: str) -> tuple[dict[str, Any], memoryview]:
    spec = importlib.util.find_spec("assimp_py")
    if spec is None or spec.origin is None:
        raise SceneError(path, "", "the library that reads it, assimp-py, is not installed", "pip install assimp-py")
    folder, size = Path(spec.origin).parent.parent, path.stat().st_size
    memory = MEMORY + MEMORY_PER_BYTE * size
    words = [sys.executable, "-I", "-S", str(_CHILD), str(path.resolve()), flags, str(memory), str(folder)]
    seconds = SECONDS + size / BYTES_A_SECOND
    try:
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired as error:
        raise _failed(path, f"could not be read within {seconds:.0f} s") from error
    out = memoryview(done.stdout)
    length = int.from_bytes(out[:8], "little")
    if done.returncode or not 8 <= 8 + length <= len(out):
        if b"MemoryError" in done.stderr:
            raise _failed(path, f"needs more than {memory >> 20} MiB to be read")
        raise _failed(path, f"crashed the library that reads it (assimp, exit code {done.returncode})")
    return json.loads(bytes(out[8 : 8 + length])), out[8 + length :]


def _failed(path: Path, problem: str) -> SceneError:
    return SceneError(path, "", problem, "the file is damaged, or too large; export it again, best as .glb")


def _part(entry: dict[str, Any], blobs: memoryview, start: int) -> tuple[Part, int]:
    indices = np.zeros((0, 3), np.uint32)  # of meshes without faces
    found: dict[str, np.ndarray | None] = dict.fromkeys(("normals", "uvs", "colors"))
    for name, width in entry["arrays"]:
        rows = entry["triangles" if name == "indices" else "vertices"]
        end = start + rows * width * 4
        if name == "indices":
            indices = np.frombuffer(blobs[start:end], np.uint32).reshape(rows, width)
        else:
            found[name] = np.frombuffer(blobs[start:end], np.float32).reshape(rows, width)
        start = end
    if indices.size and int(indices.max()) >= entry["vertices"]:  # some of assimp's readers do not look
        raise AssimpRefusal("RuntimeError", f"a face names vertex {int(indices.max())} of {entry['vertices']}")
    return Part(entry["name"], entry["material"], indices=indices, **found), start  # type: ignore[arg-type]


def _placed(nodes: list[dict[str, Any]]) -> list[Placed]:
    world: list[np.ndarray] = []
    for node in nodes:
        matrix = np.array(node["matrix"], np.float64)
        world.append(world[node["parent"]] @ matrix if node["parent"] >= 0 else matrix)
    return [Placed(n["name"], m, tuple(n["parts"])) for n, m in zip(nodes, world, strict=True) if n["parts"]]
