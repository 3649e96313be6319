"""Poses: where nodes stand, and what they carry and deform follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ..cameras import Camera
from ..errors import OctoluxError
from ..lights import AreaLight, Light, ParticleLights
from ..meshes import Instance, Mesh
from ..nodes import Node, Skin
from .deformation import deformed
from .moved import carried_camera, carried_light, rotation_matrix

if TYPE_CHECKING:
    from ..scene import Scene

Carried = TypeVar("Carried", Light, Camera)


def posed(scene: Scene, nodes: list[Node], weights: Mapping[int, Sequence[float]]) -> Scene:
    """The scene with other nodes, as many as it has, and everything that they move.

    weights: for nodes, new weights of the morph targets of the meshes they show. What does not move stays the same
    object, and a deformed mesh shares all arrays but positions, normals and tangents. Raises OctoluxError when a
    transform to world is not finite.
    """
    before, after = world_transforms(scene.nodes), world_transforms(nodes)
    lost = ~np.isfinite(after).all(axis=(1, 2))
    if lost.any():
        number = int(np.argmax(lost))
        raise OctoluxError(f"node {number} '{nodes[number].name}': its transform to world is not finite")
    moved = (before != after).any(axis=(1, 2))
    meshes, instances = list(scene.meshes), []
    for old in scene.instances:
        new = _carried(old, after, moved, weights)
        skin = None if new.skin is None else scene.skins[new.skin]
        if new.morph_weights != old.morph_weights or (skin and moved[list(skin.joints)].any()):
            meshes[new.mesh] = posed_mesh(scene.meshes[new.mesh], new, skin, after)
        instances.append(new)
    return replace(
        scene,
        nodes=nodes,
        meshes=scene.meshes if all(a is b for a, b in zip(meshes, scene.meshes, strict=True)) else meshes,
        instances=instances,
        lights=[_following(light, carried_light, after, moved) for light in scene.lights],
        cameras=[_following(camera, carried_camera, after, moved) for camera in scene.cameras],
    )


def posed_mesh(mesh: Mesh, instance: Instance, skin: Skin | None, worlds: np.ndarray) -> Mesh:
    """The deformable mesh of `instance` as it is when nodes stand at `worlds`, float64 (nodes, 4, 4).

    Joints place a skin's vertices in the world; the mesh holds them in the space that `Instance.transform` leads to
    the world from. Raises OctoluxError when a vertex is not finite.
    """
    palette = None
    if skin is not None:
        palette = np.linalg.inv(instance.transform) @ worlds[list(skin.joints)] @ skin.inverse_bind
    result = deformed(mesh, instance.morph_weights, palette)
    if not np.isfinite(result.positions).all():
        raise OctoluxError(f"mesh '{mesh.name}': the pose of its nodes and weights leads beyond all bounds")
    return result


def world_transforms(nodes: Sequence[Node]) -> np.ndarray:
    """float64 (nodes, 4, 4): each node's space to world. Raises ValueError when a node stands before its parent."""
    levels = _levels(nodes)
    worlds = _local_transforms(nodes)
    parents = np.array([0 if node.parent is None else node.parent for node in nodes], dtype=np.intp)
    with np.errstate(over="ignore", invalid="ignore"):
        for level in range(1, int(levels.max(initial=0)) + 1):
            here = np.flatnonzero(levels == level)
            worlds[here] = worlds[parents[here]] @ worlds[here]
    return worlds


def _levels(nodes: Sequence[Node]) -> np.ndarray:
    """int (nodes,): how many nodes are above each."""
    levels: list[int] = []
    for number, node in enumerate(nodes):
        if node.parent is not None and not 0 <= node.parent < number:
            raise ValueError(f"node {number} '{node.name}' stands before its parent {node.parent}")
        levels.append(0 if node.parent is None else levels[node.parent] + 1)
    return np.array(levels, dtype=np.intp)


def _local_transforms(nodes: Sequence[Node]) -> np.ndarray:
    """float64 (nodes, 4, 4): each node's space to its parent's."""
    rotation = np.array([node.rotation for node in nodes], dtype=np.float64).reshape(-1, 4)
    result = np.zeros((len(nodes), 4, 4))
    result[:, :3, :3] = np.moveaxis(rotation_matrix(rotation.T), -1, 0)
    result[:, :3, :3] *= np.array([node.scale for node in nodes], dtype=np.float64).reshape(-1, 1, 3)
    result[:, :3, 3] = np.array([node.translation for node in nodes], dtype=np.float64).reshape(-1, 3)
    result[:, 3, 3] = 1.0
    for number, node in enumerate(nodes):
        if node.matrix is not None:
            result[number] = node.matrix
    return result


def _carried(old: Instance, worlds: np.ndarray, moved: np.ndarray, weights: Mapping[int, Sequence[float]]) -> Instance:
    if old.node is None:
        return old
    new = old
    if old.skin is None and moved[old.node]:
        new = replace(new, transform=worlds[old.node].copy())
    if old.morph_weights and tuple(weights.get(old.node, old.morph_weights)) != old.morph_weights:
        new = replace(new, morph_weights=tuple(weights[old.node]))
    return new


def _following(old: Carried, carry: Callable[[Carried, np.ndarray], Carried], worlds: np.ndarray,
               moved: np.ndarray) -> Carried:
    node = None if isinstance(old, AreaLight | ParticleLights) else old.node
    return old if node is None or not moved[node] else carry(old, worlds[node])
