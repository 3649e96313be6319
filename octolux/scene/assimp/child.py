"""Reads one model with assimp, in a process of its own that may crash, hang or run out of memory.

    python -I -S child.py MODEL FLAG,FLAG,... MOST_BYTES FOLDER_OF_ASSIMP_PY

Writes to standard output: the length of a JSON text as 8 bytes, little-endian; the text; the arrays that it names, one
after the other. It imports nothing of octolux or NumPy, so that it starts in 15 ms.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
from typing import Any, BinaryIO


def main(path: str, flags: str, most_bytes: str, folder: str) -> None:
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # whatever the importer prints must not get between the bytes
    _limit_memory(int(most_bytes))
    sys.path.append(folder)
    import assimp_py

    try:
        scene = assimp_py.import_file(path, sum(getattr(assimp_py, f"Process_{flag}") for flag in flags.split(",")))
    except Exception as error:
        return _write(output, {"error": type(error).__name__, "text": str(error)}, [])
    blobs: list[bytes] = []
    parts = [_part(mesh, blobs) for mesh in scene.meshes]
    materials = [{key: value for key, value in m.items() if key != "TEXTURES"} for m in scene.materials]
    textures = [{str(kind): files for kind, files in m["TEXTURES"].items()} for m in scene.materials]
    header = {"parts": parts, "materials": materials, "textures": textures, "nodes": _nodes(scene.root_node)}
    _write(output, header, blobs)


def _limit_memory(most_bytes: int) -> None:
    with contextlib.suppress(ImportError, OSError, ValueError):  # no such module on Windows; macOS may refuse
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (most_bytes, most_bytes))


def _part(mesh: Any, blobs: list[bytes]) -> dict[str, Any]:
    """Name, material and counts; the arrays go to `blobs` in the order of "arrays"."""
    arrays: list[tuple[str, int]] = []

    def add(name: str, values: Any, width: int) -> None:
        if values is not None and width:
            blobs.append(bytes(values))
            arrays.append((name, width))

    add("positions", mesh.vertices, 3)
    add("indices", mesh.indices, 3)
    add("normals", mesh.normals, 3)
    if mesh.texcoords:
        add("uvs", mesh.texcoords[0], mesh.num_uv_components[0])
    if mesh.colors:
        add("colors", mesh.colors[0], 4)
    counts = {"vertices": mesh.num_vertices, "triangles": mesh.num_indices // 3}
    return {"name": mesh.name, "material": mesh.material_index, **counts, "arrays": arrays}


def _nodes(root: Any) -> list[dict[str, Any]]:
    """All nodes, parents before children; not recursive, for files may nest as deep as they like."""
    found: list[dict[str, Any]] = []
    waiting = [(root, -1)]
    while waiting:
        node, parent = waiting.pop()
        matrix = [list(row) for row in node.transformation]
        found.append({"name": node.name, "parent": parent, "matrix": matrix, "parts": list(node.mesh_indices)})
        number = len(found) - 1
        waiting += [(child, number) for child in reversed(node.children)]
    return found


def _write(output: BinaryIO, header: dict[str, Any], blobs: list[bytes]) -> None:
    text = json.dumps(header).encode("utf-8", "backslashreplace")
    output.write(len(text).to_bytes(8, "little") + text)
    for blob in blobs:
        output.write(blob)
    output.close()


if __name__ == "__main__":
    main(*sys.argv[1:5])
