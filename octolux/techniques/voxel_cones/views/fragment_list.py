"""The list of voxel fragments (VCT 5.2.1), which a build uses up as it goes: made again, to be looked at."""

from __future__ import annotations

import numpy as np

from ....gpu.bindings import atomic_words, storage_rw
from ....gpu.device import DeviceError
from ....gpu.limits import DEFAULT_LIMITS
from ....gpu.profiler import Profiler
from ....gpu_scene.gpu_scene import GpuScene
from ....raytracing.bvh import triangle_ids
from ....simulator.voxels.fragments import SAMPLES
from ..octree.pools import parameters, threads
from ..voxels.structure import VoxelOctree
from ..voxels.voxeliser import Voxeliser, geometry_resources
from .contents import cells_of

FRAGMENT = np.dtype([("triangle", np.uint32), ("voxel", np.int32, 3), ("share", np.float32)])
"""As simulator/voxels/fragments.Fragments; triangle: place in `triangle_ids`."""
_WORDS = 4  # that mark.wgsl lists of each
_MOST = DEFAULT_LIMITS["max-storage-buffer-binding-size"] // (4 * _WORDS)


class FragmentList(Voxeliser):
    """Fragments of what is drawn of a scene, in an octree's voxels."""

    def list(self, scene: GpuScene, octree: VoxelOctree) -> np.ndarray:
        """FRAGMENT (m,), by voxels and triangles. Raises DeviceError when there are more than a buffer holds."""
        ids = triangle_ids(scene)
        cube, profiler = self.cube(octree.grid, octree.peak), Profiler(self.device, "off")
        listed = self._over_tiles([atomic_words("fragment_count", "u32"), storage_rw("fragments", "vec4u")], True)
        with profiler.frame():
            triangles = self.triangles(profiler, scene, ids, cube)
        room, found = 0, np.zeros((0, _WORDS), np.uint32)
        while triangles.tiles:  # the first time they are counted
            count = self.device.buffer("voxel views", size=4)
            fragments = self.device.buffer("voxel views", size=4 * _WORDS * max(1, room))
            with profiler.frame(), profiler.stage("fragments") as stage:
                listed.run(
                    stage, threads(triangles.tiles), cube=cube, ids=triangles.ids, starts=triangles.starts,
                    parameters=parameters(self.device, triangles.count, second=triangles.tiles, third=room),
                    fragment_count=count, fragments=fragments, **geometry_resources(scene),
                )  # fmt: skip
            if room:
                found = np.frombuffer(self.device.queue.read_buffer(fragments), np.uint32).reshape(-1, _WORDS)
                break
            room = int(np.frombuffer(self.device.queue.read_buffer(count), np.uint32)[0])
            if not room:
                break
            if room > _MOST:
                raise DeviceError(f"There are {room} voxel fragments; {_MOST} can be listed. Set a smaller depth.")
        return _unpacked(found, octree.depth)


def _unpacked(words: np.ndarray, depth: int) -> np.ndarray:
    words = words[np.lexsort((words[:, 0], words[:, 1]))]  # threads list them in any order
    made = np.zeros(len(words), FRAGMENT)
    made["triangle"], made["voxel"] = words[:, 0], cells_of(words[:, 1], depth)
    made["share"] = words[:, 2] / SAMPLES**2
    return made
