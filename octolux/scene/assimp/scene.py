"""Scenes from the formats that assimp reads: PLY, STL, OFF, FBX, Collada and others; docs/scenes.md lists them.

Decisions, which hold for all of them:

- Materials are read as MTL's are (`obj_materials`): diffuse is Kd, specular times its strength is Ks, the exponent is
  Ns, opacity is d, and so on. All surfaces are double sided. Formats without materials get the grey default; with
  vertex colours, white.
- Vertex colours are sRGB: scanners and painters store what they show on the screen.
- Normals that a file leaves out are smooth, with edges where faces turn by more than 52.5 degrees (`creases`). STL
  holds one for each face and is flat.
- assimp turns Collada, FBX, 3DS and ASE files to y up, and scales Collada and FBX, which name their unit, to metres.
  The others name neither; they are taken as they are. `up` and `unit` in a TOML scene correct them.
- Lights, cameras, skins, motion and embedded textures are not passed on by the binding.
"""

from __future__ import annotations

from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from ...simulator.tonemap import srgb_decode
from ..errors import SceneError
from ..geometry import triangles as geometry
from ..geometry.creases import creased
from ..materials import Color
from ..meshes import Instance, Mesh
from ..obj import materials as obj_materials
from ..obj.mtl import MapLine, MtlEntry
from ..scene import Scene
from .loader import AssimpRefusal, Model, Part, import_model

WITHOUT_MATERIALS = (".ply", ".stl", ".off", ".3mf")
EXTENSIONS = (*WITHOUT_MATERIALS, ".fbx", ".dae", ".3ds", ".ase", ".lwo", ".x", ".x3d", ".ms3d", ".ac")
"""What tests/scene/test_assimp.py loads. assimp lists more, but some of its readers are known to fail on most files."""
# aiTextureType (assimp, material.h) and the MTL map that means the same.
_MAPS = {1: "map_kd", 12: "map_kd", 4: "map_ke", 14: "map_ke", 8: "map_d", 5: "bump", 6: "norm"}
# The exponent for a shininess of 1: X3D's is in [0, 1] and 128 times that is the exponent (ISO 19775-1, 17.2.2.4).
_EXPONENTS = {".x3d": 128.0}
_EMBEDDED = "*"  # assimp's names of textures inside the file: "*0", "*1"


def load_assimp(path: str | Path) -> Scene:
    """Load a model in one of EXTENSIONS: an instance for each node and mesh, named as the node.

    Raises SceneError: no such file, the reader refuses or crashes, no triangle with an area, positions or transforms
    that are not finite, broken images. What is left out or missing is noted in `Scene.warnings`.
    """
    path = Path(path)
    kind = path.suffix.lower()
    scene = Scene(name=path.stem)
    try:
        model = import_model(path, ("GlobalScale",) if kind == ".fbx" else ())
    except AssimpRefusal as refusal:
        raise _refused(path, refusal) from refusal
    entries = [_entry(model, number, kind, scene.warnings) for number in range(len(model.materials))]
    scene.materials = obj_materials.convert(((e, path.parent) for e in entries), scene.warnings)
    scene.meshes = [_mesh(path, part) for part in model.parts]
    for placed in model.placed:
        if not np.isfinite(placed.matrix).all():
            raise SceneError(path, f"node '{placed.name}'", "its transform is not finite", "export the model again")
        names = [placed.name or model.parts[n].name for n in placed.parts]
        scene.instances += [
            Instance(n, placed.matrix, name) for n, name in zip(placed.parts, names, strict=True)
        ]
    if not any(geometry.has_area(scene.meshes[i.mesh].positions, scene.meshes[i.mesh].indices).any()
               for i in scene.instances):
        raise SceneError(path, "", "the model holds no triangle with an area", "export it with faces")
    return scene


def _refused(path: Path, refusal: AssimpRefusal) -> SceneError:
    if refusal.kind == "ValueError":
        problem, remedy = "holds lines or points, and only faces can be drawn", "export it with faces alone"
    else:
        reason = str(refusal).rpartition(": ")[2].strip().rstrip(".") or "it holds no model"
        problem, remedy = f"cannot be read: {reason}", "export it again, best as .glb"
    return SceneError(path, "", problem, remedy)


def _entry(model: Model, number: int, kind: str, warnings: list[str]) -> MtlEntry:
    """One of assimp's materials as an MTL entry."""
    properties = model.materials[number]
    name = properties.get("NAME") or "default"
    entry = MtlEntry(name, maps=_maps(name, model.textures[number], warnings))
    if kind in WITHOUT_MATERIALS:
        colored = any(p.colors is not None for p in model.parts if p.material == number)
        entry.colors["kd"] = (1.0, 1.0, 1.0) if colored else obj_materials.DEFAULT.base_color
        return entry
    strength = _number(properties, "SHININESS_STRENGTH", 1.0)
    diffuse = _color(properties, "COLOR_DIFFUSE", obj_materials.DEFAULT.base_color)
    red, green, blue = _color(properties, "COLOR_SPECULAR", (0.0, 0.0, 0.0))
    entry.colors["kd"] = (min(diffuse[0], 1.0), min(diffuse[1], 1.0), min(diffuse[2], 1.0))
    entry.colors["ks"] = (red * strength, green * strength, blue * strength)
    entry.colors["ke"] = _color(properties, "COLOR_EMISSIVE", (0.0, 0.0, 0.0))
    entry.numbers["ns"] = _number(properties, "SHININESS", 0.0) * _EXPONENTS.get(kind, 1.0)
    # Exporters of FBX and 3DS write 0 for surfaces that are not transparent; nobody models what cannot be seen.
    entry.numbers["d"] = _number(properties, "OPACITY", 1.0) or 1.0
    return entry


def _maps(name: str, textures: dict[int, list[str]], warnings: list[str]) -> dict[str, MapLine]:
    maps = {_MAPS[kind]: MapLine(files[0]) for kind, files in textures.items() if kind in _MAPS and files and files[0]}
    embedded = sorted(slot for slot, line in maps.items() if line.file.startswith(_EMBEDDED))
    for slot in embedded:
        del maps[slot]
    if embedded:
        warnings.append(f"material '{name}': textures inside the file are not read; save them beside it, or use .glb")
    return maps


def _number(properties: dict[str, Any], key: str, default: float) -> float:
    """A number that is finite and not negative, or `default`."""
    value = properties.get(key, default)
    return float(value) if isinstance(value, int | float) and isfinite(value) and value >= 0 else default


def _color(properties: dict[str, Any], key: str, default: Color) -> Color:
    """A colour, linear; channels that are not finite or negative are 0."""
    value = properties.get(key)
    if not isinstance(value, list) or len(value) < 3:
        return default
    red, green, blue = (float(c) if isfinite(c) and c >= 0 else 0.0 for c in value[:3])
    return red, green, blue


def _mesh(path: Path, part: Part) -> Mesh:
    if not np.isfinite(part.positions).all():
        raise SceneError(path, f"mesh '{part.name}'", "a position is not finite", "export the model again")
    positions, indices, uvs, colors = part.positions, part.indices, part.image_uvs(), _linear(part.colors)
    if part.normals is None:
        positions, normals, indices, (uvs, colors) = creased(positions, indices, (uvs, colors))  # type: ignore[assignment]
    else:
        normals = geometry.repair_normals(positions, part.normals, indices)
    mesh = Mesh(positions=positions, normals=normals, uvs=uvs, indices=indices, material=part.material,
                tangents=geometry.tangents(positions, normals, uvs, indices), name=part.name)
    return mesh if colors is None else replace(mesh, colors=colors)


def _linear(colors: np.ndarray | None) -> np.ndarray | None:
    """Vertex colours, sRGB to linear; the alpha beside them is linear already."""
    if colors is None:
        return None
    stored = np.clip(np.nan_to_num(colors), 0.0, 1.0)
    return np.column_stack([srgb_decode(stored[:, :3]), stored[:, 3:]]).astype(np.float32)
