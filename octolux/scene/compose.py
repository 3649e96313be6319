"""Scenes made from scenes: placed elsewhere, thinned out, stripped of textures, put together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import count
from typing import Any

import numpy as np

from .cameras import Camera, look_at
from .geometry.triangles import flat, tangents
from .lights import AreaLight, DirectionalLight, Light, ParticleLights, PointLight, Vector
from .materials import Material
from .meshes import Mesh
from .motion.movers import Movers
from .motion.tracks import Track
from .nodes import Node
from .scene import Scene


def placed(scene: Scene, matrix: np.ndarray) -> Scene:
    """The scene moved as a whole by `matrix`, float64 (4, 4), invertible.

    Lights and cameras move along; light keeps its strength (candela, lux, nits) whatever the scale, as in glTF. Nodes
    get a new one above them, which has the matrix; tracks of instances, which act in the world, act in its space.
    """
    if np.array_equal(matrix, np.eye(4)):
        return scene
    if scene.nodes or any(track.target == "instance" for track in scene.tracks):
        scene = _rooted(scene, matrix)
    return replace(
        scene,
        instances=[replace(i, transform=matrix @ i.transform) for i in scene.instances],
        lights=[_placed_light(light, matrix) for light in scene.lights],
        cameras=[_placed_camera(camera, matrix) for camera in scene.cameras],
        tracks=[_placed_track(track, matrix) for track in scene.tracks],
    )


def without(scene: Scene, patterns: Iterable[str]) -> Scene:
    """The scene without the instances whose own, mesh's or material's name matches a pattern (exact, or a glob as in
    fnmatch, case-sensitive), and without meshes and materials that nothing uses then.

    Raises LookupError with the pattern when one matches nothing.
    """
    dropped: set[int] = set()
    for pattern in patterns:
        found = {number for number, names in enumerate(_names(scene)) if any(matches(n, pattern) for n in names)}
        if not found:
            raise LookupError(pattern)
        dropped |= found
    if not dropped:
        return scene
    return _pruned(replace(scene, instances=[i for n, i in enumerate(scene.instances) if n not in dropped]))


def droppable_names(scene: Scene) -> list[str]:
    """The names that `without` looks at."""
    return list(dict.fromkeys(name for names in _names(scene) for name in names if name))


def matches(name: str, pattern: str) -> bool:
    """Whether `name` is `pattern` or matches it as a glob; names with brackets in them can be given as they are."""
    return name == pattern or fnmatchcase(name, pattern)


def flat_shaded(scene: Scene) -> Scene:
    """The scene with geometric normals: each triangle has its own three vertices and its face's normal."""
    return replace(scene, meshes=[_flat_mesh(mesh) for mesh in scene.meshes])


def untextured(material: Material) -> Material:
    """The material without its textures; the factors beside them stay."""
    return replace(material, base_color_texture=None, metallic_roughness_texture=None, normal_texture=None,
                   emissive_texture=None)


def combined(scenes: Iterable[Scene], name: str = "") -> Scene:
    """All of the scenes in one. Environment and exposure are those of the first scene that has any.

    Tracks find what they move by its name: where scenes have objects of one name and it moves in one of them, those of
    the later scene get a number behind it.
    """
    result = Scene(name=name)
    for scene in scenes:
        scene = _told_apart(scene, result)
        meshes, materials, skins = len(result.meshes), len(result.materials), len(result.skins)
        scene = _renumbered(scene, len(result.nodes))
        result.meshes += [replace(m, material=m.material + materials) for m in scene.meshes]
        result.instances += [replace(i, mesh=i.mesh + meshes, skin=None if i.skin is None else i.skin + skins)
                             for i in scene.instances]  # fmt: skip
        result.nodes += scene.nodes
        result.skins += scene.skins
        result.materials += scene.materials
        result.lights += scene.lights
        result.cameras += scene.cameras
        result.tracks += scene.tracks
        result.warnings += scene.warnings
        if result.environment.is_black:
            result.environment = scene.environment
        if result.exposure is None:
            result.exposure = scene.exposure
    return result


def _told_apart(scene: Scene, other: Scene) -> Scene:
    """The scene with other names for what one of the two has tracks for and both have."""
    moving = {(track.target, track.name) for track in (*scene.tracks, *other.tracks) if track.target != "node"}
    here, there = _targets(scene), _targets(other)
    renamed: dict[tuple[str, str], str] = {}
    for kind, name in here & there & moving:
        renamed[kind, name] = _free(name, {n for k, n in here | there if k == kind})
    if not renamed:
        return scene
    return replace(
        scene,
        instances=[replace(i, name=renamed.get(("instance", i.name), i.name)) for i in scene.instances],
        lights=[replace(light, name=renamed.get(("light", light.name), light.name)) for light in scene.lights],
        cameras=[replace(camera, name=renamed.get(("camera", camera.name), camera.name)) for camera in scene.cameras],
        tracks=[replace(track, name=renamed.get((track.target, track.name), track.name)) for track in scene.tracks],
    )


def _targets(scene: Scene) -> set[tuple[str, str]]:
    """What tracks may name, as kind and name."""
    return {*(("instance", i.name) for i in scene.instances), *(("light", light.name) for light in scene.lights),
            *(("camera", camera.name) for camera in scene.cameras)}  # fmt: skip


def _free(name: str, taken: set[str]) -> str:
    return next(free for free in (f"{name} {number}" for number in count(2)) if free not in taken)


def _names(scene: Scene) -> list[tuple[str, str, str]]:
    """For each instance its own, its mesh's and its material's name."""
    meshes = [scene.meshes[i.mesh] for i in scene.instances]
    return [(i.name, m.name, scene.materials[m.material].name if scene.materials else "")
            for i, m in zip(scene.instances, meshes, strict=True)]


def _pruned(scene: Scene) -> Scene:
    used = sorted({i.mesh for i in scene.instances})
    colors = sorted({scene.meshes[m].material for m in used})
    return replace(
        scene,
        meshes=[replace(scene.meshes[m], material=colors.index(scene.meshes[m].material)) for m in used],
        instances=[replace(i, mesh=used.index(i.mesh)) for i in scene.instances],
        materials=[scene.materials[c] for c in colors if c < len(scene.materials)],
    )


def _flat_mesh(mesh: Mesh) -> Mesh:
    corners, pose = mesh.indices.ravel(), _flat_arrays(mesh.positions, mesh.uvs, mesh.indices)
    if mesh.deformable is None:
        deformable = None
    else:
        base = _flat_arrays(mesh.deformable.positions, mesh.uvs, mesh.indices)
        movers = Movers(mesh.deformable.targets, mesh.deformable.joints, mesh.deformable.weights).take(corners)
        movers = movers.flat(base["positions"], base["normals"], base["indices"])
        deformable = movers.deformable(base["positions"], base["normals"], base["tangents"])
    colors = None if mesh.colors is None else mesh.colors[corners]
    return replace(mesh, **pose, colors=colors, deformable=deformable)


def _flat_arrays(positions: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> dict[str, Any]:
    positions, normals, uvs, indices = flat(positions, uvs, indices)
    return {"positions": positions, "normals": normals, "uvs": uvs, "indices": indices,
            "tangents": tangents(positions, normals, uvs, indices)}  # fmt: skip


def _rooted(scene: Scene, matrix: np.ndarray) -> Scene:
    """The scene with one more node, 0, above all others; nothing else is moved yet."""
    scene = _renumbered(scene, 1)
    below = [replace(node, parent=0) if node.parent is None else node for node in scene.nodes]
    tracks = [replace(track, index=0) if track.target == "instance" and track.index is None else track
              for track in scene.tracks]  # fmt: skip
    return replace(scene, nodes=[Node(matrix=np.array(matrix), name=scene.name), *below], tracks=tracks)


def _renumbered(scene: Scene, more: int) -> Scene:
    """The scene as it is when `more` nodes stand before its own."""
    if not more:
        return scene

    def moved(number: int | None) -> int | None:
        return None if number is None else number + more

    return replace(
        scene,
        nodes=[replace(node, parent=moved(node.parent)) for node in scene.nodes],
        skins=[replace(skin, joints=tuple(joint + more for joint in skin.joints)) for skin in scene.skins],
        instances=[replace(i, node=moved(i.node)) for i in scene.instances],
        lights=[
            o if isinstance(o, AreaLight | ParticleLights) else replace(o, node=moved(o.node)) for o in scene.lights
        ],
        cameras=[replace(camera, node=moved(camera.node)) for camera in scene.cameras],
        tracks=[replace(track, index=moved(track.index)) for track in scene.tracks],
    )


def _point(matrix: np.ndarray, point) -> Vector:
    x, y, z = (matrix[:3, :3] @ np.asarray(point, dtype=np.float64) + matrix[:3, 3]).tolist()
    return x, y, z


def _direction(matrix: np.ndarray, direction) -> Vector:
    x, y, z = (matrix[:3, :3] @ np.asarray(direction, dtype=np.float64)).tolist()
    return x, y, z


def _placed_light(light: Light, matrix: np.ndarray) -> Light:
    if isinstance(light, DirectionalLight):
        return replace(light, direction=_direction(matrix, light.direction))
    if isinstance(light, PointLight):
        return replace(light, position=_point(matrix, light.position))
    if isinstance(light, ParticleLights):
        return light.moved(matrix)
    if isinstance(light, AreaLight):
        a, b, c, d = (_point(matrix, corner) for corner in light.corners)
        # A mirrored quadrilateral would shine to its other side.
        return replace(light, corners=(a, b, c, d) if np.linalg.det(matrix[:3, :3]) > 0 else (a, d, c, b))
    return replace(light, position=_point(matrix, light.position), direction=_direction(matrix, light.direction))


def _placed_camera(camera: Camera, matrix: np.ndarray) -> Camera:
    position, forward = np.array(_point(matrix, camera.position)), np.array(_direction(matrix, camera.forward))
    scale = float(abs(np.linalg.det(matrix[:3, :3]))) ** (1.0 / 3.0)
    height = camera.orthographic_height
    return replace(
        camera,
        transform=look_at(position, position + forward, _direction(matrix, camera.transform[:3, 1])),
        near=camera.near * scale,
        orthographic_height=None if height is None else height * scale,
    )


def _placed_track(track: Track, matrix: np.ndarray) -> Track:
    if track.target not in ("light", "camera") or track.property not in ("position", "look_at", "direction"):
        return track
    moved = np.array([_direction(matrix, value) for value in track.values.reshape(-1, 3)]).reshape(track.values.shape)
    values = moved[:, 1] if track.interpolation == "cubic" else moved  # the rest are slopes, which do not shift
    if track.property != "direction":
        values += matrix[:3, 3]
    return replace(track, values=moved)
