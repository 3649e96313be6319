"""Clusters: each mesh cut into runs of at most 128 triangles that lie close together; a view draws those it sees."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..scene.meshes import Mesh

CLUSTER_TRIANGLES = 128
_MORTON_BITS = 10


@dataclass(frozen=True)
class Clusters:
    """One mesh's triangles in cluster order.

    indices: uint32 (triangles, 3).  first, count: int64 (clusters,), triangles of each cluster.
    low, high: float64 (clusters, 3), boxes in object space.
    """

    indices: np.ndarray
    first: np.ndarray
    count: np.ndarray
    low: np.ndarray
    high: np.ndarray


def _spread(bits: np.ndarray) -> np.ndarray:
    """Ten bits with two zeros between each: interleaving three of these gives a Morton code."""
    bits = (bits | bits << 16) & 0x030000FF
    bits = (bits | bits << 8) & 0x0300F00F
    bits = (bits | bits << 4) & 0x030C30C3
    return (bits | bits << 2) & 0x09249249


def _morton_order(centroids: np.ndarray) -> np.ndarray:
    low, high = centroids.min(axis=0), centroids.max(axis=0)
    scale = (2**_MORTON_BITS - 1) / max(float((high - low).max()), 1e-30)
    cells = ((centroids - low) * scale).astype(np.int64)
    return np.argsort(_spread(cells[:, 0]) | _spread(cells[:, 1]) << 1 | _spread(cells[:, 2]) << 2, kind="stable")


def cluster(mesh: Mesh) -> Clusters:
    """Sort the triangles of `mesh` along a Morton curve and cut them into clusters."""
    corners = mesh.positions[mesh.indices].astype(np.float64)
    order = _morton_order(corners.mean(axis=1))
    first = np.arange(0, len(order), CLUSTER_TRIANGLES)
    count = np.minimum(CLUSTER_TRIANGLES, len(order) - first)
    low = np.minimum.reduceat(corners[order].min(axis=1), first)
    high = np.maximum.reduceat(corners[order].max(axis=1), first)
    return Clusters(mesh.indices[order], first, count, low, high)


def refitted(clusters: Clusters, mesh: Mesh) -> Clusters:
    """The same clusters around the vertices of `mesh`, which has the same triangles."""
    corners = mesh.positions[clusters.indices].astype(np.float64)
    low = np.minimum.reduceat(corners.min(axis=1), clusters.first)
    high = np.maximum.reduceat(corners.max(axis=1), clusters.first)
    return replace(clusters, low=low, high=high)


def world_boxes(low: np.ndarray, high: np.ndarray, transforms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes that hold the object-space boxes (n, 3) after `transforms` (n, 4, 4), or (4, 4) for all."""
    linear, moved = transforms[..., :3, :3], transforms[..., :3, 3]
    centre, extent = (low + high) / 2, (high - low) / 2
    centre = (linear @ centre[..., None])[..., 0] + moved
    extent = (np.abs(linear) @ extent[..., None])[..., 0]
    return centre - extent, centre + extent


def visible(low: np.ndarray, high: np.ndarray, view_projection: np.ndarray) -> np.ndarray:
    """Which world-space boxes (n, 3) may be seen: bool (n,).

    A box is out when it lies wholly outside one of the five planes left, right, bottom, top, near (Gribb and Hartmann
    2001); there is no far plane (reverse z keeps z >= 0).
    """
    x, y, z, w = view_projection
    planes = np.stack([w + x, w - x, w + y, w - y, w - z, z])
    centre, extent = (low + high) / 2, (high - low) / 2
    distance = centre @ planes[:, :3].T + planes[:, 3]
    reach = extent @ np.abs(planes[:, :3]).T
    return ~(distance + reach < 0).any(axis=1)
