"""The node hierarchy of a glTF file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..motion.pose import world_transforms
from ..nodes import Node
from .json import Fields

_IDENTITY = tuple(np.eye(4).ravel())


@dataclass(frozen=True)
class NodeTable:
    """The nodes of a file.

    nodes: all of them, parents before children; they are `Scene.nodes`.
    numbers: for each of the file's nodes its index into `nodes`.
    worlds: float64 (nodes, 4, 4), each node's space to world, in the order of `nodes`.
    shown: those of the scene that the file shows, as (JSON, index into `nodes`).
    """

    nodes: list[Node]
    numbers: list[int]
    worlds: np.ndarray
    shown: list[tuple[Fields, int]]


def read_nodes(root: Fields) -> NodeTable:
    """The nodes of a file. It shows the scene `scene`, else the first, else all nodes.

    Raises SceneError: cycles, two parents, a node listed twice, transforms that are not finite.
    """
    fields = root.children("nodes", "node")
    children = [node.indices("children", len(fields), "node") for node in fields]
    parents = _parents(fields, children)
    order = _order(children, [index for index, parent in enumerate(parents) if parent is None])
    numbers = [0] * len(fields)
    for number, index in enumerate(order):
        numbers[index] = number
    nodes = [_node(fields[index], None if (p := parents[index]) is None else numbers[p]) for index in order]
    worlds = world_transforms(nodes)
    for number, finite in enumerate(np.isfinite(worlds).all(axis=(1, 2))):
        if not finite:
            raise fields[order[number]].error("its transform to world is not finite")
    return NodeTable(nodes, numbers, worlds, [(fields[i], numbers[i]) for i in _shown(root, fields, children, order)])


def _parents(nodes: list[Fields], children: list[list[int]]) -> list[int | None]:
    parents: list[int | None] = [None] * len(nodes)
    for parent, below in enumerate(children):
        for child in below:
            if parents[child] is not None:
                raise nodes[child].error(f"it is a child of node {parents[child]} and again of node {parent}")
            parents[child] = parent
    settled = [False] * len(nodes)
    for start in range(len(nodes)):
        path: list[int] = []
        index: int | None = start
        while index is not None and not settled[index]:
            if len(path) > len(nodes):
                raise nodes[start].error("it is below itself: the node hierarchy has a cycle")
            path.append(index)
            index = parents[index]
        for passed in path:
            settled[passed] = True
    return parents


def _order(children: list[list[int]], top: list[int]) -> list[int]:
    """The nodes at and below `top`, each before its children and those before its next sibling."""
    pending, order = top[::-1], []
    while pending:
        order.append(pending.pop())
        pending += reversed(children[order[-1]])
    return order


def _shown(root: Fields, nodes: list[Fields], children: list[list[int]], order: list[int]) -> list[int]:
    scenes = root.children("scenes", "scene")
    if not scenes:
        return order
    listed = scenes[root.index("scene", len(scenes), "scene") or 0].indices("nodes", len(nodes), "node")
    seen: set[int] = set()
    for top in listed:  # one after the other, so that a file that lists a node often is found out early
        below = _order(children, [top])
        for index in below:
            if index in seen:
                raise nodes[index].error("the scene lists it twice, as its own node and below another")
        seen.update(below)
    return _order(children, listed)


def _node(fields: Fields, parent: int | None) -> Node:
    """One node (section 3.5.3), its `matrix` row by row. Raises SceneError."""
    name = fields.string("name", "")
    if "matrix" in fields:
        matrix = np.array(fields.numbers("matrix", 16, _IDENTITY)).reshape(4, 4).T
        if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0)):
            raise fields.error("the last row of its 'matrix' is not 0 0 0 1")
        return Node(parent=parent, matrix=matrix, name=name)
    rotation = np.array(fields.numbers("rotation", 4, (0.0, 0.0, 0.0, 1.0)))
    length = np.linalg.norm(rotation)
    if not length > 1e-6:
        raise fields.error("its 'rotation' is a quaternion of length zero")
    return Node(
        parent=parent,
        translation=fields.numbers("translation", 3, (0.0, 0.0, 0.0)),
        rotation=tuple((rotation / length).tolist()),
        scale=fields.numbers("scale", 3, (1.0, 1.0, 1.0)),
        name=name,
    )
