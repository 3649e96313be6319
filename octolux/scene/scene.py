"""The scene: everything a picture is made from. Plain data, no GPU."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .animation import Track
from .cameras import Camera
from .environment import Environment
from .lights import Light
from .materials import Material
from .meshes import Instance, Mesh
from .motion import moved_camera, moved_instance, moved_light
from .nodes import Node, Skin


@dataclass(kw_only=True)
class Scene:
    """Meshes, instances, materials, lights, cameras and keyframes. Right-handed, y up, metres, linear Rec. 709.

    Lists may be changed at any time; their elements are frozen, so replace an element to change it
    (`dataclasses.replace`). What names a node stands where that node stands.
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
    nodes: list[Node] = field(default_factory=list)
    skins: list[Skin] = field(default_factory=list)
    tracks: list[Track] = field(default_factory=list)
    exposure: float | None = None
    warnings: list[str] = field(default_factory=list)

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

    def at(self, time: float) -> Scene:
        """The scene as it is at `time` seconds: every track evaluated, none left. Shares meshes and materials.

        Before its first and after its last keyframe a track holds. A track whose object is missing does nothing.
        """
        values = {(t.target, t.name, t.property): t.at(time) for t in self.tracks}

        def of(target: str, name: str) -> dict[str, np.ndarray]:
            return {key[2]: value for key, value in values.items() if key[:2] == (target, name)}

        return replace(
            self,
            instances=[moved_instance(i, of("instance", i.name)) for i in self.instances],
            lights=[moved_light(light, of("light", light.name)) for light in self.lights],
            cameras=[moved_camera(camera, of("camera", camera.name)) for camera in self.cameras],
            tracks=[],
        )
