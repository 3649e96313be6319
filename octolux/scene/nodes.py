"""Nodes and skins: the hierarchy by which parts of a model move together (glTF 2.0, sections 3.5 and 3.7.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Node:
    """A coordinate system below another.

    parent: index into `Scene.nodes`, or None; a parent stands before its children in the list.
    translation (3,), metres; rotation (4,), unit quaternion x y z w; scale (3,): applied in the order scale, rotation,
    translation. matrix: float64 (4, 4) that stands for all three where they are not given singly; such a node is not
    animated.
    """

    parent: int | None = None
    translation: tuple[float, ...] = (0.0, 0.0, 0.0)
    rotation: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)
    matrix: np.ndarray | None = None
    name: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class Skin:
    """Joints that carry a mesh's vertices.

    joints: indices into `Scene.nodes`.
    inverse_bind: float64 (joints, 4, 4), mesh space to each joint's space in the pose the mesh was modelled in.
    """

    joints: tuple[int, ...]
    inverse_bind: np.ndarray
    name: str = ""
