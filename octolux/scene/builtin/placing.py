"""Putting parts together: meshes and the instances that place them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import cos, radians, sin

import numpy as np

from ..materials import Color, Material
from ..meshes import Instance, Mesh
from .textures import Surface


@dataclass
class Parts:
    """The meshes and instances of a scene, collected part by part."""

    meshes: list[Mesh] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)

    def add(self, *meshes: Mesh) -> None:
        """Meshes that stand where they were made; each instance has its mesh's name."""
        for mesh in meshes:
            self.instances.append(Instance(len(self.meshes), name=mesh.name))
            self.meshes.append(mesh)

    def place(self, meshes: Iterable[Mesh], transforms: dict[str, np.ndarray]) -> None:
        """Each mesh at each of the transforms (4, 4), as the instance "place mesh"."""
        for mesh in meshes:
            number = len(self.meshes)
            self.meshes.append(mesh)
            self.instances += [Instance(number, matrix, f"{name} {mesh.name}") for name, matrix in transforms.items()]


def placed(x: float, y: float, z: float, degrees: float = 0.0, scale: float = 1.0) -> np.ndarray:
    """float64 (4, 4): scaled, turned about y (counter-clockwise seen from above), then moved to (x, y, z)."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    transform = np.eye(4)
    transform[:3, :3] = scale * np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    transform[:3, 3] = x, y, z
    return transform


def transformed(mesh: Mesh, matrix: np.ndarray, name: str | None = None) -> Mesh:
    """The mesh moved by `matrix` (4, 4), which turns, moves and scales alike in all directions."""
    turn = matrix[:3, :3] / np.cbrt(np.linalg.det(matrix[:3, :3]))
    tangents = np.concatenate([mesh.tangents[:, :3] @ turn.T, mesh.tangents[:, 3:]], axis=1)
    return replace(
        mesh,
        positions=(mesh.positions @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32),
        normals=(mesh.normals @ turn.T).astype(np.float32),
        tangents=tangents.astype(np.float32),
        name=mesh.name if name is None else name,
    )


def tilted(degrees: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """float64 (4, 4): turned about x (y towards z), then moved to (x, y, z)."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    transform = np.eye(4)
    transform[:3, :3] = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]
    transform[:3, 3] = x, y, z
    return transform


def aimed(place, direction) -> np.ndarray:
    """float64 (4, 4): what points along -y is turned towards `direction` (3,), then moved to `place` (3,)."""
    transform = np.eye(4)
    y = -np.asarray(direction, dtype=np.float64)
    y /= np.linalg.norm(y)
    x = np.cross(y, np.eye(3)[np.abs(y).argmin()])
    x /= np.linalg.norm(x)
    transform[:3, :3] = np.stack([x, y, np.cross(x, y)], axis=1)
    transform[:3, 3] = place
    return transform


def plain(name: str, color: Color, roughness: float, **rest) -> Material:
    """A material of one linear base colour."""
    return Material(name=name, base_color=color, roughness=roughness, **rest)


def textured(name: str, surface: Surface, roughness: float, **rest) -> Material:
    """A material with the two maps of a surface."""
    return Material(name=name, base_color_texture=surface.base_color, normal_texture=surface.normal,
                    roughness=roughness, **rest)
