"""The valid scenes that `mutations` damages: one small file of every kind that octolux reads, with what it names.

Some are cut from the data folder's models, others are written here or by the tests of the loaders.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from .lab import data
from .written_gltf import Files, compressed, draco, figure, of_tests, textured
from .written_pictures import exr, hdr, picture


@dataclass(frozen=True)
class Original:
    """A valid scene: the name of its main file, and what makes all files by name. share: how often it is taken."""

    main: str
    make: Callable[[], Files]
    share: int = 2
    needs_data: bool = False


_KINDS = {"png": "PNG", "jpg": "JPEG", "webp": "WEBP", "tga": "TGA", "bmp": "BMP", "tif": "TIFF", "gif": "GIF",
          "dds": "DDS", "ppm": "PPM"}  # fmt: skip
_TABLES = of_tests("toml_files")


def obj(kind: str) -> Files:
    """Two triangles with three textures of one format: colour, mask and bump."""
    name = f"wood.{kind}"
    text = (f"newmtl oak\nKd 0.5 0.4 0.3\nNs 40\nmap_Kd {name}\nmap_d {name}\nnewmtl pine\nKd 0.2 0.2 0.2\nKs 0.4\n"
            f"Ke 1 2 3\nd 0.5\nillum 3\nmap_Ke -o 1 2 3 {name}\nbump -bm 0.5 {name}\n")  # fmt: skip
    return {"model.obj": _TABLES.OBJ.encode(), "model.mtl": text.encode(), name: picture(_KINDS[kind])}


_TOML = """name = "hall"
exposure = 2.5
[environment]
radiance = [0.1, 0.2, 0.3]
image = "sky.{sky}"
scale = 2.0
rotate = 30
[animation]
clip = "bend"
[[model]]
file = "model.glb"
unit = "cm"
scale = [1.0, 2.0, 1.0]
rotate = [10, 20, 30]
translate = [1, 2, 3]
normals = "flat"
[[model]]
file = "model.obj"
up = "z"
matrix = [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
drop = ["far"]
[[material]]
name = "oak"
base_color = [0.5, 0.4, 0.3]
emissive = [1, 2, 3]
roughness = 0.5
alpha_mode = "blend"
{lights}[[camera]]
name = "eye"
position = [0, 1, 8]
look_at = [0, 0, 0]
up = [0, 1, 0]
vertical_fov = 60
near = 0.05
[[keyframes]]
target = "light:lamp"
property = "position"
times = [0.0, 1.0, 2.0]
values = [[0, 1, 0], [1, 2, 0], [0, 1, 0]]
interpolation = "smooth"
loop = true
[[keyframes]]
target = "camera:eye"
property = "position"
times = [0.0, 2.0]
values = [[0, 1, 8], [1, 2, 8]]
[[keyframes]]
target = "instance:near"
property = "rotation"
times = [0.0, 2.0]
values = [[0, 0, 0, 1], [0, 1, 0, 0]]
"""


def toml(sky: str) -> Files:
    """Every table of a TOML scene; two models, and surroundings in a format of their own."""
    image = {"hdr": hdr, "exr": exr, "png": lambda: picture("PNG")}[sky]()
    text = _TOML.format(sky=sky, lights=_TABLES.SPOT + _TABLES.SUN + _TABLES.LAMP)
    return {"scene.toml": text.encode(), f"sky.{sky}": image, "model.glb": figure().glb(),
            **obj("png")}  # fmt: skip


def binary_stl() -> bytes:
    corners = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    return bytes(80) + struct.pack("<I", 2) + corners * 2


def bunny(binary: bool) -> Files:
    """The triangles among the first 3,000 vertices of the Stanford bunny."""
    lines = data("scenes", "stanford-bunny", "bun_zipper.ply").read_text().splitlines()
    start = lines.index("end_header") + 1
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    points = np.array([line.split()[:3] for line in lines[start : start + 3000]], np.float32)
    faces = np.array([line.split()[1:4] for line in lines[start + count :]], np.int64)
    faces = faces[(faces < len(points)).all(axis=1)]
    kind = "binary_little_endian" if binary else "ascii"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = (f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\n{axes}element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n").encode()  # fmt: skip
    if binary:
        rows = np.zeros(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
        rows["n"], rows["v"] = 3, faces
        return {"bunny.ply": head + points.tobytes() + rows.tobytes()}
    texts = [" ".join(f"{v:g}" for v in point) for point in points] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return {"bunny.ply": head + "\n".join(texts).encode() + b"\n"}


def _copied(*names: str) -> Callable[[], Files]:
    """Files of the data folder's `scenes`, flat."""
    return lambda: {Path(name).name: data("scenes", *name.split("/")).read_bytes() for name in names}


def _box(name: str) -> Original:
    path = f"cornell-box/CornellBox-{name}"
    return Original(f"CornellBox-{name}.obj", _copied(f"{path}.obj", f"{path}.mtl"), 3, True)


def _model(folder: str, *names: str, share: int = 4) -> Original:
    return Original(names[0], _copied(*(f"{folder}/{name}" for name in names)), share, True)


_CHAIR = [f"SheenChair{name}.jpg" for name in (
    "BaseColor", "FabricNormal", "FabricOcclusion", "LabelBaseColor", "Occlusion-SheenChairBaseColor",
    "Occlusion-SheenChairWoodMetallicRoughness", "Occlusion", "WoodBaseColor")]  # fmt: skip

ORIGINALS: tuple[Original, ...] = (
    Original("model.gltf", lambda: figure().files(), 8),
    Original("model.glb", lambda: {"model.glb": figure().glb()}, 6),
    Original("model.gltf", textured, 14),
    Original("model.gltf", lambda: draco(True), 4),
    Original("model.gltf", lambda: draco(False), 4),
    Original("model.gltf", compressed, 5),
    *(Original("model.obj", lambda kind=kind: obj(kind), 2) for kind in _KINDS),  # type: ignore[misc]
    *(Original("scene.toml", lambda sky=sky: toml(sky), share)  # type: ignore[misc]
      for sky, share in (("hdr", 5), ("exr", 5), ("png", 2))),
    *(Original(f"square{kind}", lambda kind=kind: {f"square{kind}": _encoded(kind)}, 1)  # type: ignore[misc]
      for kind in of_tests("model_files").FILES),
    Original("square.stl", lambda: {"square.stl": binary_stl()}, 1),
    _model("gltf/01_alpha_mask", "01_alpha_mask.gltf", "01_alpha_mask.bin", "01_alpha_mask.png"),
    _model("gltf/14_emission_strength", "14_emission_strength.gltf", "14_emission_strength.bin",
           "14_emission_strength.png", share=3),
    _model("gltf/23_sparse_multi_prim", "23_multi_prim_vertex_attribute.gltf", "23_multi_prim_vertex_attribute.bin"),
    _model("gltf/Fox", "Fox.glb", share=6),
    _model("gltf/pirate-meshopt", "pirate.glb", share=5),
    _model("cornell-box", "bevy-CornellBox.glb"),
    _model("cornell-box/kajiya-gltf", "scene.gltf", "scene.bin"),
    _model("gltf/Draco-2CylinderEngine", "2CylinderEngine.gltf", "2CylinderEngine.bin", share=1),
    _model("gltf/MixedLightingExample", "MixedLightingExample.gltf", "MixedLightingExample.bin", *_CHAIR, share=1),
    *(_box(name) for name in ("Original", "Mirror", "Empty-CO", "Glossy")),
    Original("bunny.ply", lambda: bunny(True), 2, True),
    Original("bunny.ply", lambda: bunny(False), 1, True),
)  # fmt: skip


def _encoded(kind: str) -> bytes:
    content = of_tests("model_files").FILES[kind]
    return content if isinstance(content, bytes) else content.encode()


@cache
def files_of(number: int) -> Files:
    """The files of ORIGINALS[number] by name. Raises NeedsData when the data folder lacks them."""
    return ORIGINALS[number].make()
