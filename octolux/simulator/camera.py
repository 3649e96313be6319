"""The rays of a camera's pixels, where points are seen, and the packing of normals in the G-buffer."""

from __future__ import annotations

from math import tan

import numpy as np

from octolux.scene.cameras import Camera

SNORM16 = 32767
"""Largest 16-bit signed normalised integer: it stands for 1."""


def pixel_rays(camera: Camera, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Origins and unit directions, float64 (height, width, 3) each, of the rays through the pixel centres.

    Row 0 is at the top and column 0 on the left. Pixels are square: `vertical_fov`, or `orthographic_height`, spans
    the rows and the width follows. Perspective rays start at the camera's position, orthographic ones in the plane
    through it. Raises ValueError for an empty picture.
    """
    if width < 1 or height < 1:
        raise ValueError(f"a picture needs at least one pixel, got {width} x {height}")
    column = (np.arange(width) + 0.5) * 2.0 / width - 1.0
    row = 1.0 - (np.arange(height) + 0.5) * 2.0 / height
    across, up = np.meshgrid(column * (width / height), row)
    rotation = camera.transform[:3, :3]
    if camera.orthographic_height is not None:
        half = 0.5 * camera.orthographic_height
        in_plane = np.stack([across * half, up * half, np.zeros_like(up)], axis=-1)
        return camera.position + in_plane @ rotation.T, np.broadcast_to(camera.forward, (height, width, 3))
    half = tan(0.5 * camera.vertical_fov)
    directions = np.stack([across * half, up * half, -np.ones_like(up)], axis=-1) @ rotation.T
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return np.broadcast_to(camera.position, directions.shape), directions


def seen_at(camera: Camera, points, width: int, height: int) -> tuple[np.ndarray, np.ndarray]:
    """Row and column (..., 2), in pixels from the upper left corner, that points (..., 3) are seen at, and their depth
    (...) along the axis, metres; what is not in front of a perspective camera has the place -1, -1."""
    local = (np.asarray(points) - camera.position) @ camera.transform[:3, :3]
    right, up, forward = local[..., 0], local[..., 1], -local[..., 2]
    half = tan(0.5 * camera.vertical_fov) * forward
    if camera.orthographic_height is not None:
        half = np.full_like(forward, 0.5 * camera.orthographic_height)
    in_front = half > 0.0
    half = np.where(in_front, half, 1.0)
    place = 0.5 * np.stack([height * (1.0 - up / half), width + height * right / half], axis=-1)
    return np.where(in_front[..., None], place, -1.0), forward


def _fold(plane: np.ndarray) -> np.ndarray:
    """Points (..., 2) of the lower half of the octahedron unfolded over the square's corners, and back."""
    return (1.0 - np.abs(plane[..., ::-1])) * np.where(plane >= 0.0, 1.0, -1.0)


def octahedral_encode(normals) -> np.ndarray:
    """Unit `normals` (..., 3) on the square [-1, 1]^2: float64 (..., 2) (Cigolle et al. 2014, listing 1).

    The direction is projected on the octahedron |x| + |y| + |z| = 1; the half z < 0 is folded outwards.
    """
    normals = np.asarray(normals, dtype=np.float64)
    octahedron = normals / np.sum(np.abs(normals), axis=-1, keepdims=True)
    plane = octahedron[..., :2]
    return np.where(octahedron[..., 2:] < 0.0, _fold(plane), plane)


def octahedral_decode(square) -> np.ndarray:
    """Unit normals (..., 3) of points of the `square` [-1, 1]^2 (..., 2), the inverse of `octahedral_encode`."""
    square = np.asarray(square, dtype=np.float64)
    z = 1.0 - np.sum(np.abs(square), axis=-1, keepdims=True)
    normals = np.concatenate([np.where(z < 0.0, _fold(square), square), z], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def pack_snorm2x16(values) -> np.ndarray:
    """Two numbers in [-1, 1] (..., 2) in one uint32 (...), bit for bit as WGSL's pack2x16snorm.

    Each is floor(0.5 + 32767 * clamp(v, -1, 1)) in two's complement; the first is in the lower 16 bits (WGSL, "Data
    Packing Built-in Functions").
    """
    clamped = np.clip(np.asarray(values, dtype=np.float64), -1.0, 1.0)
    words = np.floor(0.5 + SNORM16 * clamped).astype(np.int64) & 0xFFFF
    return (words[..., 0] | (words[..., 1] << 16)).astype(np.uint32)


def unpack_snorm2x16(packed) -> np.ndarray:
    """The inverse of `pack_snorm2x16`: uint32 (...) to float64 (..., 2), max(v / 32767, -1)."""
    packed = np.asarray(packed, dtype=np.uint32)
    words = np.stack([packed & 0xFFFF, packed >> 16], axis=-1).astype(np.uint16).view(np.int16)
    return np.maximum(words / SNORM16, -1.0)


def pack_normals(normals) -> np.ndarray:
    """Unit `normals` (..., 3) in one uint32 (...) each: octahedral, two 16-bit snorm.

    The round trip turns a normal by at most sqrt(18) / 2 / 32767 = 6.5e-5 rad: each coordinate moves by at most
    e = 1/2 / 32767, a point of the octahedron by at most sqrt(6) e, and it is at least 1 / sqrt(3) from the centre.
    """
    return pack_snorm2x16(octahedral_encode(normals))


def unpack_normals(packed) -> np.ndarray:
    """Unit normals (..., 3) of `packed` uint32 (...), see `pack_normals`."""
    return octahedral_decode(unpack_snorm2x16(packed))
