"""The scene: everything a picture is made from. Plain data, no GPU."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, get_args

import numpy as np

from .cameras import Camera
from .environment import Environment
from .errors import OctoluxError
from .lights import Light
from .materials import Material
from .medium import Medium
from .meshes import Instance, Mesh
from .motion.moved import moved_camera, moved_instance, moved_light, moved_node
from .motion.pose import posed, world_transforms
from .motion.tracks import Target, Track
from .nodes import Node, Skin


@dataclass(kw_only=True)
class Scene:
    """Meshes, instances, materials, lights, cameras and keyframes. Right-handed, y up, metres, linear Rec. 709.

    Lists may be changed at any time; their elements are frozen, so replace an element to change it
    (`dataclasses.replace`). What names a node stands where that node stands, and deformed meshes are in the pose of the
    nodes; `pose.posed` gives a scene with its nodes moved.
    `medium` is what fills the air, None for clear air.
    `exposure` is in EV100, or None when the source names none.
    `warnings` holds what a loader had to leave out or guess.
    """

    name: str = ""
    meshes: list[Mesh] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    cameras: list[Camera] = field(default_factory=list)
    environment: Environment = field(default_factory=Environment)
    medium: Medium | None = None
    nodes: list[Node] = field(default_factory=list)
    skins: list[Skin] = field(default_factory=list)
    tracks: list[Track] = field(default_factory=list)
    exposure: float | None = None
    warnings: list[str] = field(default_factory=list)

    @classmethod
    def from_arrays(cls, positions: Any, indices: Any, normals: Any = None, uvs: Any = None, colors: Any = None,
                    material: Material | None = None, name: str = "") -> Scene:
        """A scene of one mesh, shown where it is: the arrays of `Mesh.from_arrays`, and its material (white when None).

        Raises OctoluxError.
        """
        mesh = Mesh.from_arrays(positions, indices, normals, uvs, colors, name=name)
        return cls(name=name, meshes=[mesh], instances=[Instance(0, name=name)],
                   materials=[material or Material(name="default", double_sided=True)])  # fmt: skip

    @property
    def triangle_count(self) -> int:
        """Triangles as drawn: each instance counts its mesh."""
        return sum(len(self.meshes[i.mesh].indices) for i in self.instances)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """World-space box of all instances: two float64 (3,), lowest and highest corner. An empty scene is a point."""
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for instance in self.instances:
            mesh = self.meshes[instance.mesh]
            if not mesh.indices.size:
                continue
            used = mesh.positions[mesh.indices.ravel()].astype(np.float64)
            world = used @ instance.transform[:3, :3].T + instance.transform[:3, 3]
            low, high = np.minimum(low, world.min(axis=0)), np.maximum(high, world.max(axis=0))
        if not np.isfinite(low).all():
            return np.zeros(3), np.zeros(3)
        return low, high

    @property
    def clips(self) -> list[str]:
        """The names of the scene's animations, in the order of its tracks."""
        return list(dict.fromkeys(track.clip for track in self.tracks if track.clip))

    @property
    def duration(self) -> float:
        """Seconds to the last keyframe of what `at` plays when no clip is named; 0 without tracks."""
        return max((float(track.times[-1]) for track in self._playing(None)), default=0.0)

    def at(self, time: float, clip: str | None = None) -> Scene:
        """The scene as it is at `time` seconds: every track of no clip and those of one clip evaluated, none left.

        clip: one of `clips`, None for the first. A track repeats after its period; without one it holds before its
        first and after its last keyframe. A track whose object is missing does nothing. What does not change stays the
        same object. Raises OctoluxError: no clip of that name, a transform that is not finite.
        """
        values = _values(self._playing(clip), time)
        scene = _with_moved_nodes(self, values["node"])
        worlds = world_transforms(scene.nodes) if any(space is not None for _, space in values["instance"]) else None
        instances = list(scene.instances)
        for (name, space), changes in values["instance"].items():
            matrix = None if space is None or worlds is None else worlds[space]
            instances = [moved_instance(i, changes, matrix) if i.name == name else i for i in instances]
        lights, cameras = ({name: changes for (name, _), changes in values[key].items()} for key in ("light", "camera"))
        return replace(
            scene,
            instances=instances,
            lights=[moved_light(light, lights.get(light.name, {})) for light in scene.lights],
            cameras=[moved_camera(camera, cameras.get(camera.name, {})) for camera in scene.cameras],
            tracks=[],
        )

    def _playing(self, clip: str | None) -> list[Track]:
        clips = self.clips
        if clip is not None and clip not in clips:
            there = "it has " + ", ".join(f"'{name}'" for name in clips) if clips else "it has none"
            raise OctoluxError(f"the scene '{self.name}' has no animation '{clip}'; {there}")
        return [t for t in self.tracks if t.clip in ("", clip if clip is not None else (clips or [""])[0])]


Values = dict[str, dict[tuple[str, int | None], dict[str, np.ndarray]]]


def _values(tracks: list[Track], time: float) -> Values:
    """What tracks say at a time, by target, by name and index, by property; of several the last one."""
    values: Values = {target: {} for target in get_args(Target)}
    for track in tracks:
        key = ("" if track.target == "node" else track.name, track.index)
        values[track.target].setdefault(key, {})[track.property] = track.at(time)
    return values


def _with_moved_nodes(scene: Scene, values: dict[tuple[str, int | None], dict[str, np.ndarray]]) -> Scene:
    changes = {i: v for (_, i), v in values.items() if i is not None and i < len(scene.nodes)}
    if not changes:
        return scene
    weights = {i: tuple(v.pop("weights").tolist()) for i, v in changes.items() if "weights" in v}
    return posed(scene, [moved_node(node, changes.get(i, {})) for i, node in enumerate(scene.nodes)], weights)
