"""glTF 2.0 and GLB: the core and the extensions in `SUPPORTED`."""

from __future__ import annotations

from pathlib import Path

from ..errors import SceneError
from ..scene import Scene
from ..warning_lines import merged
from .accessors import Accessors
from .animation import read_animations
from .carried import read_cameras, read_lights
from .container import read_buffers, read_container
from .json import Fields
from .materials import MaterialReader
from .meshes import MeshTable, read_meshes
from .nodes import read_nodes
from .skins import read_instances, read_skins

# KHR_mesh_quantization only widens the component types of attributes, all of which are read anyway.
SUPPORTED = {
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
}


def load_gltf(path: str | Path) -> Scene:
    """Load a .gltf or .glb file: the scene that it shows, with its animations as clips.

    Each primitive of triangles becomes a Mesh, and an instance for each node that shows it, named as the node (or its
    mesh). Mirroring transforms are kept. Lights are in candela and lux, emission in nits, as the extensions say. Where
    primitives name no material, glTF's default stands behind the file's own.

    Lines, points and optional extensions that are not supported are left out and noted in `Scene.warnings`, as are
    missing images. Everything else that is wrong raises SceneError with its place ("accessor 3"): the file itself,
    required extensions, indices, lengths and offsets out of range, values that are not finite, wrong types, cycles of
    nodes, missing buffers, no triangle with an area.
    """
    path = Path(path)
    root, binary = read_container(path)
    scene = Scene(name=path.stem)
    _check_version(root)
    _check_extensions(root, scene.warnings)
    accessors = Accessors(root, read_buffers(root, binary))
    scene.materials, uv_uses = MaterialReader(root, accessors, scene.warnings).read()
    table = read_meshes(root, accessors, uv_uses, scene.warnings)
    if all(mesh.material < len(scene.materials) - 1 for mesh in table.meshes):
        scene.materials.pop()
    nodes = read_nodes(root)
    scene.nodes, scene.skins = nodes.nodes, read_skins(root, accessors, nodes)
    scene.meshes, scene.instances = read_instances(nodes, table, scene.skins, scene.warnings)
    scene.cameras = read_cameras(root, nodes)
    scene.lights = read_lights(root, nodes, scene.warnings)
    scene.tracks = read_animations(root, accessors, nodes, table, scene.warnings)
    if not scene.triangle_count:
        raise _nothing(path, table)
    scene.warnings = merged(scene.warnings)
    return scene


def _check_version(root: Fields) -> None:
    asset = root.child("asset")
    if asset is None:
        raise root.error("'asset' is missing, so this is no glTF 2.0 file")
    version = asset.string("minVersion", asset.string("version"))
    if version.split(".")[0] != "2":
        raise asset.error(f"glTF version '{version}' is not supported", "export the model as glTF 2.0")


def _check_extensions(root: Fields, warnings: list[str]) -> None:
    required = root.strings("extensionsRequired")
    for name in required:
        if name not in SUPPORTED:
            problem = f"the file requires the extension {name}, which is not supported"
            raise SceneError(root.file, "extensionsRequired", problem, f"export the model without {name}")
    for name in root.strings("extensionsUsed"):
        if name not in SUPPORTED:
            warnings.append(f"extension {name} is not supported; what it says is left out")


def _nothing(path: Path, table: MeshTable) -> SceneError:
    remedy = "export the model with its triangles, in the scene that the file shows"
    if table.empty:
        return SceneError(path, table.empty[0], "no triangle has an area", remedy)
    problem = "no node of the scene shows a mesh of triangles" if table.parts else "the file has no meshes"
    return SceneError(path, "nodes" if table.parts else "meshes", problem, remedy)
