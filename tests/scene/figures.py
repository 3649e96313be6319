"""A glTF figure: a strip of two joints, and animations for it."""

from __future__ import annotations

from math import sqrt

import numpy as np

# Three rows of two vertices at y = 0, 1, 2, facing +z. Row 0 follows the first joint, row 2 the second, row 1 both.
POSITIONS = np.array([[x, y, 0] for y in (0, 1, 2) for x in (-0.5, 0.5)], np.float32)
JOINTS = np.tile(np.array([0, 1, 0, 0], np.uint8), (6, 1))
WEIGHTS = np.repeat(np.array([[1, 0, 0, 0], [0.5, 0.5, 0, 0], [0, 1, 0, 0]], np.float32), 2, axis=0)
TRIANGLES = np.array([0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4], np.uint16)
QUARTER_X = (sqrt(0.5), 0.0, 0.0, sqrt(0.5))
"""By 90 degrees about x: +y becomes +z, +z becomes -y."""

BENT = np.array([[x, *yz] for yz in ((0, 0), (1, 0), (1, 1)) for x in (-0.5, 0.5)])
"""The strip's positions with the second joint turned so: the upper row goes round (0, 1, 0)."""

BENT_NORMALS = np.repeat([[0, 0, 1], [0, -sqrt(0.5), sqrt(0.5)], [0, -1, 0]], 2, axis=0)


def add_strip(gltf) -> dict:
    """Node 0 shows the strip, nodes 1 and 2 are its joints; gives the primitive."""
    inverse_bind = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1))
    inverse_bind[1, 1, 3] = -1.0
    attributes = {
        "POSITION": gltf.add(POSITIONS),
        "NORMAL": gltf.add(np.tile(np.array([0, 0, 1], np.float32), (6, 1))),
        "TEXCOORD_0": gltf.add(POSITIONS[:, :2] * np.float32([1, -1])),
        "JOINTS_0": gltf.add(JOINTS),
        "WEIGHTS_0": gltf.add(WEIGHTS),
    }
    primitive = {"attributes": attributes, "indices": gltf.add(TRIANGLES)}
    matrices = gltf.add(inverse_bind.transpose(0, 2, 1).reshape(2, 16))
    gltf.json |= {
        "meshes": [{"name": "strip", "primitives": [primitive]}],
        "nodes": [{"name": "figure", "mesh": 0, "skin": 0}, {"name": "lower", "children": [2]},
                  {"name": "upper", "translation": [0, 1, 0]}],
        "scenes": [{"nodes": [0, 1]}],
        "skins": [{"joints": [1, 2], "inverseBindMatrices": matrices}],
    }  # fmt: skip
    return primitive


def add_animation(gltf, node: int, path: str, times, values, interpolation: str = "LINEAR", name: str = "") -> None:
    """An animation of one channel; values float or of an integer type, which are then normalised."""
    values = np.asarray(values)
    values = values.astype(np.float32) if values.dtype.kind not in "iu" or values.itemsize > 2 else values
    more = {} if values.dtype == np.float32 else {"normalized": True}
    flat = values.reshape(-1) if path == "weights" else values.reshape(-1, values.shape[-1])
    sampler = {"input": gltf.add(np.array(times, np.float32)), "output": gltf.add(flat, **more),
               "interpolation": interpolation}  # fmt: skip
    channel = {"sampler": 0, "target": {"node": node, "path": path}}
    animation = {"samplers": [sampler], "channels": [channel], **({"name": name} if name else {})}
    gltf.json.setdefault("animations", []).append(animation)
