"""glTF animations: each channel becomes one Track (glTF 2.0, section 3.11 and appendix C)."""

from __future__ import annotations

import numpy as np

from ..motion.tracks import Interpolation, Track
from .accessors import Accessors, require
from .json import Fields
from .meshes import MeshTable
from .nodes import NodeTable

_INTERPOLATIONS: dict[str, Interpolation] = {"LINEAR": "linear", "STEP": "step", "CUBICSPLINE": "cubic"}
_WIDTHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": 1}


def read_animations(
    root: Fields, accessors: Accessors, nodes: NodeTable, table: MeshTable, warnings: list[str]
) -> list[Track]:
    """The tracks of all animations; each repeats after the last keyframe of its animation, as viewers have it.

    Their clips are the animations' names, or "animation 0" and so on, with a number behind a name that is taken.
    Channels of other extensions' paths are left out with a warning. Raises SceneError.
    """
    tracks: list[Track] = []
    clips: set[str] = set()
    fields = root.children("nodes", "node")
    for number, animation in enumerate(root.children("animations", "animation")):
        name = _free_name(animation.string("name", "") or f"animation {number}", clips)
        tracks += _Reader(animation, accessors, nodes, fields, table, warnings).tracks(name)
    return tracks


def _free_name(name: str, taken: set[str]) -> str:
    free, count = name, 1
    while free in taken:
        count += 1
        free = f"{name} {count}"
    taken.add(free)
    return free


class _Reader:
    """Reads one animation."""

    def __init__(self, animation: Fields, accessors: Accessors, nodes: NodeTable, fields: list[Fields],
                 table: MeshTable, warnings: list[str]):
        self.animation, self.accessors, self.nodes, self.table = animation, accessors, nodes, table
        self.fields, self.warnings = fields, warnings
        self.samplers = animation.children("samplers", "sampler")

    def tracks(self, clip: str) -> list[Track]:
        channels = self.animation.children("channels", "channel")
        if not channels or not self.samplers:
            raise self.animation.error("it has no channels or no samplers")
        read = [self._channel(channel) for channel in channels]
        kept = [(node, path, sampler) for found in read if found for node, path, sampler in [found]]
        values = [(node, path, *self._sampler(sampler, node, path)) for node, path, sampler in kept]
        period = max((float(times[-1]) for _, _, times, _, _ in values), default=0.0)
        return [
            Track(target="node", name=self.nodes.nodes[self.nodes.numbers[node]].name, property=path, times=times,
                  values=outputs, index=self.nodes.numbers[node], interpolation=interpolation, clip=clip,
                  period=period if period > 0 else None)
            for node, path, times, outputs, interpolation in values
        ]  # fmt: skip

    def _channel(self, channel: Fields) -> tuple[int, str, Fields] | None:
        """The file's node, the path and the sampler of a channel, or None when it is left out."""
        sampler = require(channel, channel.index("sampler", len(self.samplers), "sampler"), "sampler")
        target = channel.child("target")
        if target is None:
            raise channel.error("'target' is missing")
        path = target.string("path")
        if path not in _WIDTHS:
            self.warnings.append(f"{channel.place}: the path '{path}' is not supported; left out")
            return None
        node = target.index("node", len(self.fields), "node")
        if node is None:  # to be ignored (section 3.11)
            return None
        reason = ""
        if path == "weights" and not self._targets(node):
            reason = "shows no mesh with morph targets"
        elif path != "weights" and "matrix" in self.fields[node]:
            reason = "has a matrix"
        if reason:
            self.warnings.append(f"{channel.place}: node {node} {reason}, so its {path} is not animated")
            return None
        return node, path, self.samplers[sampler]

    def _targets(self, node: int) -> int:
        """How many morph targets the mesh of one of the file's nodes has."""
        mesh = self.fields[node].index("mesh", len(self.table.targets), "mesh")
        return 0 if mesh is None else self.table.targets[mesh]

    def _sampler(self, sampler: Fields, node: int, path: str) -> tuple[np.ndarray, np.ndarray, Interpolation]:
        """Times (keys,), values as `Track` has them, interpolation."""
        name = sampler.string("interpolation", "LINEAR")
        if name not in _INTERPOLATIONS:
            raise sampler.error(f"'interpolation' is '{name}', must be {', '.join(_INTERPOLATIONS)}")
        inputs, outputs = (require(sampler, sampler.index(key, len(self.accessors), "accessor"), key)
                           for key in ("input", "output"))  # fmt: skip
        times = self.accessors.vectors(inputs, 1)[:, 0].astype(np.float64)
        if not (np.diff(times) >= 0).all():
            raise sampler.error("its times do not increase")
        values = self.accessors.vectors(outputs, _WIDTHS[path]).astype(np.float64)
        cubic = name == "CUBICSPLINE"
        expected = len(times) * (3 if cubic else 1) * (self._targets(node) if path == "weights" else 1)
        if len(values) != expected:
            raise sampler.error(f"its output has {len(values)} elements, {len(times)} keys need {expected}")
        values = values.reshape(len(times), 3, -1) if cubic else values.reshape(len(times), -1)
        if path == "rotation" and not (values[:, 1] if cubic else values).any(axis=-1).all():
            raise sampler.error("it holds a rotation of length zero")
        return times, values, _INTERPOLATIONS[name]
