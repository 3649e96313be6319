"""Scenes from trimesh's objects. Nothing else needs trimesh; who has such an object has imported it.

Decisions: trimesh's uvs point up and are turned; vertex and face colours are sRGB; lengths become metres where the
object names its unit. Normals are made anew (`creases`), for trimesh smooths its own over every edge. Its lights have
no photometric unit and are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import radians
from typing import Any

import numpy as np

from ..cameras import Camera
from ..compose import placed
from ..errors import SceneError
from ..geometry.extents import check_extent
from ..images.decode import from_pillow
from ..materials import AlphaMode, Image, Material, Texture
from ..meshes import Instance, Mesh
from ..obj.materials import DEFAULT, roughness
from ..scene import Scene

_MODES: dict[str | None, AlphaMode] = {"MASK": "mask", "BLEND": "blend"}


def from_trimesh(source: Any) -> Scene:
    """The scene that a trimesh.Trimesh or trimesh.Scene holds: meshes, materials, textures, places and its camera.

    Raises OctoluxError: no such object, or arrays that are not finite. What is no mesh (point clouds, paths) is left
    out and noted in `Scene.warnings`.
    """
    import trimesh

    if isinstance(source, trimesh.Trimesh):
        source = trimesh.Scene(source)
    if not isinstance(source, trimesh.Scene):
        problem = "is neither a trimesh.Trimesh nor a trimesh.Scene"
        raise SceneError(type(source).__name__, "", problem, "give one of them")
    result = _Converter(Scene(name="trimesh"))
    for node in source.graph.nodes_geometry:
        matrix, geometry = source.graph[node]
        result.add(str(node), np.asarray(matrix, np.float64), str(geometry), source.geometry[geometry], trimesh.Trimesh)
    if source.has_camera and source.camera.name in source.graph.nodes:
        matrix = np.array(source.camera_transform, np.float64)
        fov = radians(float(source.camera.fov[1]))
        result.scene.cameras.append(Camera(transform=matrix, vertical_fov=fov, name="camera"))
    try:
        scale = trimesh.units.unit_conversion(source.units, "meters") if source.units else 1.0
    except (KeyError, ValueError) as error:
        raise SceneError("trimesh.Scene", "units", f"is '{source.units}'", "name a unit that trimesh knows") from error
    scene = placed(result.scene, np.diag([scale, scale, scale, 1.0]))
    check_extent(scene, "trimesh.Scene")
    return scene


@dataclass
class _Converter:
    """Adds geometries to a scene, each mesh, material and image once."""

    scene: Scene
    meshes: dict[str, int | None] = field(default_factory=dict)
    materials: dict[int, int] = field(default_factory=dict)
    images: dict[int, Image] = field(default_factory=dict)

    def add(self, node: str, matrix: np.ndarray, name: str, geometry: Any, mesh_class: type) -> None:
        if name not in self.meshes:
            self.meshes[name] = self._mesh(name, geometry) if isinstance(geometry, mesh_class) else None
            if self.meshes[name] is None:
                self.scene.warnings.append(f"'{name}', a {type(geometry).__name__}, is left out; only meshes are drawn")
        number = self.meshes[name]
        if number is not None:
            self.scene.instances.append(Instance(number, matrix, node))

    def _mesh(self, name: str, source: Any) -> int:
        visual = source.visual
        uvs = getattr(visual, "uv", None) if visual.kind == "texture" else None
        if uvs is not None and len(uvs):
            uvs = np.column_stack([np.asarray(uvs)[:, 0], 1.0 - np.asarray(uvs)[:, 1]])
        colors = visual.vertex_colors if visual.kind == "vertex" else None
        mesh = Mesh.from_arrays(source.vertices, source.faces, uvs=uvs, colors=colors, name=name)
        if visual.kind == "face":
            mesh = _with_face_colors(mesh, np.asarray(visual.face_colors))
        material = self._material(visual.material if visual.kind == "texture" else None, mesh.colors is not None)
        self.scene.meshes.append(replace(mesh, material=material))
        return len(self.scene.meshes) - 1

    def _material(self, source: Any, colored: bool) -> int:
        key = id(source) if source is not None else -int(colored)
        if key not in self.materials:
            if source is None:
                made = replace(DEFAULT, base_color=(1.0, 1.0, 1.0)) if colored else DEFAULT
            else:
                made = self._metallic(source) if hasattr(source, "baseColorFactor") else self._simple(source)
            self.scene.materials.append(made)
            self.materials[key] = len(self.scene.materials) - 1
        return self.materials[key]

    def _metallic(self, m: Any) -> Material:
        """A PBRMaterial, whose names and meanings are those of glTF; factors of colours are linear bytes there."""
        red, green, blue, alpha = _bytes(m.baseColorFactor)
        return Material(
            name=str(m.name or ""), base_color=(red, green, blue), alpha=alpha,
            base_color_texture=self._texture(m.baseColorTexture),
            metallic=1.0 if m.metallicFactor is None else float(m.metallicFactor),
            roughness=1.0 if m.roughnessFactor is None else float(m.roughnessFactor),
            metallic_roughness_texture=self._texture(m.metallicRoughnessTexture),
            normal_texture=self._texture(m.normalTexture),
            emissive=(0.0, 0.0, 0.0) if m.emissiveFactor is None else _three(m.emissiveFactor),
            emissive_texture=self._texture(m.emissiveTexture),
            alpha_mode=_MODES.get(m.alphaMode, "opaque"),
            alpha_cutoff=0.5 if m.alphaCutoff is None else float(m.alphaCutoff),
            double_sided=bool(m.doubleSided),
        )  # fmt: skip

    def _simple(self, m: Any) -> Material:
        """A SimpleMaterial, which is an MTL entry; read as `obj_materials` reads those."""
        red, green, blue, alpha = _bytes(m.diffuse)
        return Material(
            name=str(m.name or ""), base_color=(1.0, 1.0, 1.0) if m.image else (red, green, blue), alpha=alpha,
            base_color_texture=self._texture(m.image), roughness=roughness(float(m.glossiness or 0.0)),
            specular=min(1.0, max(_bytes(m.specular)[:3]) / 0.04), alpha_mode="blend" if alpha < 1.0 else "opaque",
            double_sided=True,
        )  # fmt: skip

    def _texture(self, picture: Any) -> Texture | None:
        if picture is None:
            return None
        if id(picture) not in self.images:
            self.images[id(picture)] = from_pillow(picture, "texture")
        return Texture(self.images[id(picture)])


def _bytes(color: Any) -> tuple[float, float, float, float]:
    """RGBA in [0, 1] of trimesh's bytes; white when None."""
    values = [255, 255, 255, 255] if color is None else [*np.asarray(color).tolist(), 255][:4]
    red, green, blue, alpha = (value / 255.0 for value in values)
    return red, green, blue, alpha


def _three(values: Any) -> tuple[float, float, float]:
    red, green, blue = (float(v) for v in values[:3])
    return red, green, blue


def _with_face_colors(mesh: Mesh, colors: np.ndarray) -> Mesh:
    """Each triangle gets vertices of its own, in its colour; normals stay."""
    corners = mesh.indices.ravel()
    return Mesh.from_arrays(
        mesh.positions[corners], np.arange(len(corners)), mesh.normals[corners], mesh.uvs[corners],
        np.repeat(colors, 3, axis=0), name=mesh.name,
    )  # fmt: skip
