"""Wavefront OBJ: geometry through assimp, materials through `mtl` and `obj_materials`."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from ..assimp.loader import AssimpRefusal, Model, Part, import_model
from ..errors import SceneError
from ..files import NotAFile
from ..geometry import triangles as geometry
from ..geometry.tangents import tangent_space
from ..meshes import Instance, Mesh
from ..scene import Scene
from . import materials as obj_materials
from .faults import cleaned, find_fault
from .mtl import MtlEntry, read_mtl

_MTLLIB = re.compile(rb"^[ \t]*mtllib[ \t]+(.+?)[ \t\r]*$", re.MULTILINE)
_UNNAMED = "DefaultMaterial"  # what assimp calls the material of faces before any `usemtl`


def load_obj(path: str | Path) -> Scene:
    """Load an OBJ model: one mesh and one instance for each group (`g`, or `o`) and material in it, named as the group.

    OBJ names no unit: coordinates are kept as they are and taken for metres. Vertices without normals get those of
    their faces (smoothing groups without normals are not read). v is flipped, for it points up in OBJ. Materials are
    all those of the MTL files, in their order, when faces name any; faces without one get a grey default.

    Raises SceneError: no such file, malformed text, indices out of range, non-finite positions, no triangles with an
    area, broken images. Missing MTL files and images, and lines or points, are left out and noted in `Scene.warnings`.
    """
    path = Path(path)
    scene = Scene(name=path.stem)
    entries = _read_libraries(path, scene.warnings)
    model = _import(path, scene.warnings)
    used = [model.materials[part.material]["NAME"] for part in model.parts]
    slots = _materials(scene, entries, used)
    for part, material in zip(model.parts, used, strict=True):
        if len(part.indices):
            normal_map = scene.materials[slots[material]].normal_texture is not None
            scene.meshes.append(_mesh(path, part, slots[material], normal_map))
            scene.instances.append(Instance(len(scene.meshes) - 1, name=part.name))
    if not any(geometry.has_area(mesh.positions, mesh.indices).any() for mesh in scene.meshes):
        raise SceneError(path, "", "the model holds no triangle with an area", "export it with faces ('f' lines)")
    return scene


def _import(path: Path, warnings: list[str]) -> Model:
    try:
        return import_model(path)
    except AssimpRefusal as refusal:
        if refusal.kind == "ValueError":  # its answer to lines and points beside the triangles
            warnings.append(f"{path}: lines and points are left out; only faces are drawn")
        elif refusal.kind != "UnicodeDecodeError":  # that to names in Latin-1 and the like
            raise _fault(path, refusal) from refusal
    try:
        with cleaned(path) as copy:
            return import_model(copy)
    except AssimpRefusal as refusal:
        raise _fault(path, refusal) from refusal


def _fault(path: Path, error: Exception) -> SceneError:
    """Assimp says what is wrong but not where; look for the line."""
    place, problem = find_fault(path) or ("", str(error).rpartition(": ")[2].strip().rstrip("."))
    return SceneError(path, place, problem, "mend the line, or export the model again as OBJ with polygons")


def _read_libraries(path: Path, warnings: list[str]) -> dict[str, tuple[MtlEntry, Path]]:
    """The entries of all MTL files that the OBJ names, by material name, each with its file's folder."""
    try:
        lines = _MTLLIB.findall(path.read_bytes())
    except OSError as error:
        remedy = "check the path and the permissions"
        raise SceneError(path, "", f"cannot be read: {error.strerror}", remedy) from error
    entries: dict[str, tuple[MtlEntry, Path]] = {}
    for written in dict.fromkeys(line.decode("utf-8", errors="replace").strip('"') for line in lines):
        library = obj_materials.find_file(path.parent, written)
        try:
            found = read_mtl(library)
        except NotAFile as error:  # assimp opens it too, and would wait
            problem = f"its material library '{written}' is a device or a pipe, not a file"
            raise SceneError(path, "mtllib", problem, "name an MTL file, or leave the line out") from error
        except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
            reason = error.strerror if isinstance(error, OSError) else error
            warnings.append(f"material library {library} is not read ({reason}); grey stands in")
            continue
        entries |= {name: (entry, library.parent) for name, entry in found.items()}
    return entries


def _materials(scene: Scene, entries: dict[str, tuple[MtlEntry, Path]], used: list[str]) -> dict[str, int]:
    """Fill `scene.materials`; returns the index for each name in `used`."""
    named = any(name in entries for name in used)
    if named:
        scene.materials += obj_materials.convert(entries.values(), scene.warnings)
    slots = {name: index for index, name in enumerate(entries if named else ())}
    missing = Counter(name for name in used if name not in slots)
    if missing:
        scene.materials.append(obj_materials.DEFAULT)
    for name in missing:
        slots[name] = len(scene.materials) - 1
        if name != _UNNAMED:
            scene.warnings.append(f"material '{name}' is in no material library; grey stands in")
    return slots


def _mesh(path: Path, part: Part, material: int, normal_map: bool) -> Mesh:
    positions, indices = part.positions, part.indices
    if not np.isfinite(positions).all():
        place, problem = find_fault(path) or (f"group '{part.name}'", "a position is not finite")
        raise SceneError(path, place, problem, "write finite numbers after 'v', or export the model again")
    uvs = part.image_uvs()
    if part.normals is None:
        positions, normals, uvs, indices = geometry.flat(positions, uvs, indices)
    else:
        normals = geometry.repair_normals(positions, part.normals, indices)
    space = tangent_space(positions, normals, uvs, indices, normal_map)
    return Mesh(
        positions=positions[space.vertices],
        normals=normals[space.vertices],
        uvs=uvs[space.vertices],
        tangents=space.tangents,
        indices=space.indices,
        material=material,
        name=part.name,
    )
