"""Meshes and scenes from arrays of any kind: what `Mesh.from_arrays` and `Scene.from_arrays` do."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...simulator.tonemap import srgb_decode
from ..errors import OctoluxError
from ..geometry import triangles as geometry
from ..geometry.creases import creased


def mesh_arrays(positions: Any, indices: Any, normals: Any, uvs: Any, colors: Any) -> dict[str, np.ndarray | None]:
    """The arrays of a `Mesh`, checked and converted; see `Mesh.from_arrays`. Raises OctoluxError."""
    points = _floats("positions", positions, (3,))
    corners = _indices(indices, len(points))
    count = len(points)
    texels = np.zeros((count, 2), np.float32) if uvs is None else geometry.usable_uvs(_floats("uvs", uvs, (2,), count))
    tints = None if colors is None else _colors(colors, count)
    if normals is None:
        points, shading, corners, (texels, tints) = creased(points, corners, (texels, tints))  # type: ignore[assignment]
    else:
        shading = geometry.repair_normals(points, _floats("normals", normals, (3,), count), corners)
    along = geometry.tangents(points, shading, texels, corners)
    return {"positions": points, "normals": shading, "uvs": texels, "tangents": along, "indices": corners,
            "colors": tints}  # fmt: skip


def _floats(name: str, values: Any, widths: tuple[int, ...], count: int | None = None) -> np.ndarray:
    """float32 (count, one of widths), finite, contiguous and not shared with the caller."""
    rows = "n" if count is None else count
    shape = " or ".join(f"({rows}, {width})" for width in widths)
    found = _array(name, values)
    if found.dtype.kind not in "fiub" or found.ndim != 2 or found.shape[1] not in widths:
        raise OctoluxError(f"{name} must be numbers of the shape {shape}, got {found.dtype} {found.shape}.")
    if count is not None and len(found) != count:
        raise OctoluxError(f"{name} must be of the shape {shape}, one row for each position, got {found.shape}.")
    with np.errstate(over="ignore"):
        converted = np.array(found, np.float32, order="C")
    if not np.isfinite(converted).all():
        row = int(np.flatnonzero(~np.isfinite(converted).all(axis=1))[0])
        raise OctoluxError(f"{name} must be finite; row {row} is {found[row].tolist()}.")
    return converted


def _array(name: str, values: Any) -> np.ndarray:
    try:
        return np.asarray(values)
    except (ValueError, TypeError) as error:  # rows of different lengths
        raise OctoluxError(f"{name} is no array of numbers: {error}.") from error


def _indices(values: Any, count: int) -> np.ndarray:
    found = _array("indices", values)
    if found.size and found.dtype.kind not in "iu" and not _whole(found):
        raise OctoluxError(f"indices must be whole numbers, got {found.dtype}.")
    if found.ndim == 1 and found.size % 3 == 0:
        found = found.reshape(-1, 3)
    if found.ndim != 2 or found.shape[1] != 3:
        raise OctoluxError(f"indices must be (triangles, 3), got {found.shape}; cut polygons in triangles.")
    if found.size and (int(found.min()) < 0 or int(found.max()) >= count):
        wrong = int(found.min()) if int(found.min()) < 0 else int(found.max())
        raise OctoluxError(f"indices must be from 0 to {count - 1}, one is {wrong}.")
    return np.array(found, np.uint32, order="C")


def _whole(found: np.ndarray) -> bool:
    return found.dtype.kind == "f" and bool(np.isfinite(found).all() and (found == np.round(found)).all())


def _colors(values: Any, count: int) -> np.ndarray:
    """float32 (count, 4), linear. Whole numbers are sRGB, fractions of their type's largest value."""
    given = _array("colors", values)
    found = _floats("colors", given, (3, 4), count)
    if given.dtype.kind in "iu":
        found = found / np.float32(np.iinfo(given.dtype).max)
    if found.size and float(found.min()) < 0:
        raise OctoluxError(f"colors must not be negative, one is {float(found.min()):g}.")
    if given.dtype.kind in "iu":
        found[:, :3] = srgb_decode(found[:, :3])
    opaque = np.ones((count, 4 - found.shape[1]), np.float32)
    return np.concatenate([found, opaque], axis=1)
