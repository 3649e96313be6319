"""Skins, and the instances of meshes that nodes show, in the pose that a glTF viewer shows first."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import OctoluxError
from ..meshes import Instance, Mesh
from ..motion.pose import posed_mesh
from ..nodes import Skin
from .accessors import Accessors
from .json import Fields
from .meshes import MeshTable
from .nodes import NodeTable


def read_skins(root: Fields, accessors: Accessors, nodes: NodeTable) -> list[Skin]:
    """The skins of a file (section 3.7.3). Raises SceneError."""
    skins = []
    for fields in root.children("skins", "skin"):
        joints = tuple(nodes.numbers[joint] for joint in fields.indices("joints", len(nodes.nodes), "node"))
        if not joints:
            raise fields.error("it has no joints")
        index = fields.index("inverseBindMatrices", len(accessors), "accessor")
        matrices = np.tile(np.eye(4), (len(joints), 1, 1)) if index is None else accessors.matrices(index)
        if len(matrices) < len(joints):
            raise fields.error(f"it has {len(joints)} joints and {len(matrices)} inverse bind matrices")
        skins.append(Skin(joints=joints, inverse_bind=matrices[: len(joints)], name=fields.string("name", "")))
    return skins


def read_instances(
    nodes: NodeTable, table: MeshTable, skins: list[Skin], warnings: list[str]
) -> tuple[list[Mesh], list[Instance]]:
    """The meshes of a scene and the instances that its nodes show, one for each primitive.

    A mesh that is deformed belongs to one instance alone and is in the pose of the nodes; instances that nothing
    deforms share meshes. Raises SceneError.
    """
    shown = [(node, part, instance) for node, number in nodes.shown
             for part, instance in _instances(node, number, nodes, table, skins, warnings)]  # fmt: skip
    meshes = _Meshes([replace(mesh, deformable=None) for mesh in table.meshes],
                     {part for _, part, instance in shown if not _deforms(table.meshes[part], instance)})  # fmt: skip
    instances = []
    for node, part, instance in shown:
        mesh, number = table.meshes[part], part
        if _deforms(mesh, instance):
            skin = None if instance.skin is None else skins[instance.skin]
            number = meshes.add(part, _posed(node, mesh, instance, skin, nodes))
        instances.append(replace(instance, mesh=number))
    return meshes.meshes, instances


@dataclass
class _Meshes:
    """Meshes under the numbers that they have in the file, and more behind them. taken: numbers that are in use."""

    meshes: list[Mesh]
    taken: set[int] = field(default_factory=set)

    def add(self, part: int, mesh: Mesh) -> int:
        """The number of a mesh that stands in for the file's mesh `part`: that one's, unless it is in use."""
        if part in self.taken:
            self.meshes.append(mesh)
            return len(self.meshes) - 1
        self.taken.add(part)
        self.meshes[part] = mesh
        return part


def _instances(node: Fields, number: int, nodes: NodeTable, table: MeshTable, skins: list[Skin],
               warnings: list[str]) -> list[tuple[int, Instance]]:
    index = node.index("mesh", len(table.parts), "mesh")
    if index is None:
        return []
    fields, targets = table.fields[index], table.targets[index]
    name = node.string("name", "") or fields.string("name", "")
    weights = node.numbers("weights", targets, fields.numbers("weights", targets, (0.0,) * targets))
    skin = node.index("skin", len(skins), "skin")
    found = []
    for part in table.parts[index]:
        world, by = nodes.worlds[number], skin
        if skin is not None and not _fits(node, table.meshes[part], skins[skin], skin):
            warnings.append(f"{node.place}: its skin does not move '{table.meshes[part].name}', which has no joints")
            by = None
        transform = world.copy() if by is None else _skinned_transform(world)
        found.append((part, Instance(part, transform, name, node=number, skin=by, morph_weights=weights)))
    return found


def _fits(node: Fields, mesh: Mesh, skin: Skin, number: int) -> bool:
    """Whether the mesh has joints. Raises SceneError when the skin has not all of them."""
    if mesh.deformable is None or mesh.deformable.joints is None:
        return False
    highest = int(mesh.deformable.joints.max())
    if highest >= len(skin.joints):
        raise node.error(f"mesh '{mesh.name}' asks for joint {highest}, skin {number} has {len(skin.joints)}")
    return True


def _skinned_transform(world: np.ndarray) -> np.ndarray:
    """Where a skinned mesh is kept: in world space, whatever its node's place; but a mirroring node mirrors, for that
    tells which side of the triangles is the front (section 3.7.4)."""
    return np.diag([-1.0 if np.linalg.det(world[:3, :3]) < 0 else 1.0, 1.0, 1.0, 1.0])


def _deforms(mesh: Mesh, instance: Instance) -> bool:
    return mesh.deformable is not None and (instance.skin is not None or bool(mesh.deformable.targets))


def _posed(node: Fields, mesh: Mesh, instance: Instance, skin: Skin | None, nodes: NodeTable) -> Mesh:
    if mesh.deformable is not None and skin is None:
        mesh = replace(mesh, deformable=replace(mesh.deformable, joints=None, weights=None))
    try:
        return posed_mesh(mesh, instance, skin, nodes.worlds)
    except OctoluxError as error:
        raise node.error(str(error)) from error
