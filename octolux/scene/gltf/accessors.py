"""Accessors: checked NumPy views of a glTF's buffers (glTF 2.0, sections 3.6.1 and 3.6.2)."""

from __future__ import annotations

import copy
from collections.abc import Mapping

import numpy as np

from .json import Fields
from .meshopt import Budget, compression, decompress

_COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_UNSIGNED = (5121, 5123, 5125)
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# An accessor without a buffer view is all zeros, whatever its count: the one place where a short file can ask for any
# amount of memory. No mesh of zeros needs more.
_MOST_ZEROS = 1 << 20


class Accessors:
    """Reads the accessors of one file. `buffers` are the file's, as `gltf_container.read_buffers` gives them."""

    def __init__(self, root: Fields, buffers: list[bytes]):
        self.buffers = buffers
        self.views = root.children("bufferViews", "bufferView")
        self.accessors = root.children("accessors", "accessor")
        self.budget = Budget()
        self._decoded: Mapping[str, np.ndarray] = {}  # by the place of an accessor
        self._decompressed: dict[str, bytes] = {}  # by the place of a buffer view

    def with_decoded(self, decoded: Mapping[int, np.ndarray]) -> Accessors:
        """These accessors, of which some have values (count, width) from elsewhere than their buffer views."""
        result = copy.copy(self)
        result._decoded = {self.accessors[index].place: values for index, values in decoded.items()}
        return result

    def element_count(self, index: int) -> int:
        """How many elements an accessor says it has. Raises SceneError."""
        return self.accessors[index].integer("count", low=1)

    def __len__(self) -> int:
        return len(self.accessors)

    def vectors(self, index: int, *widths: int) -> np.ndarray:
        """float32 (count, width): integers are normalised when the accessor says so. All values are finite.

        widths: which are allowed. Raises SceneError.
        """
        fields = self.accessors[index]
        values = self._elements(fields, widths)
        kind = values.dtype
        result = values.astype(np.float32)
        if fields.boolean("normalized", False):
            if kind == np.float32 or kind == np.uint32:
                raise fields.error("floats and 32-bit integers cannot be 'normalized'")
            result = np.maximum(result / np.float32(np.iinfo(kind).max), np.float32(-1.0))
        if not np.isfinite(result).all():
            element = int(np.argwhere(~np.isfinite(result))[0, 0])
            raise fields.error(f"element {element} is not finite", "export the model again without NaN or infinity")
        return result

    def integers(self, index: int) -> np.ndarray:
        """uint32 (count,): vertex indices. Raises SceneError."""
        fields = self.accessors[index]
        values = self._elements(fields, (1,))[:, 0]
        if values.dtype.kind != "u":
            raise fields.error("indices must be unsigned integers")
        return values.astype(np.uint32)

    def joints(self, index: int) -> np.ndarray:
        """uint16 (count, 4): positions in a skin's list of joints. Raises SceneError."""
        values = self._elements(self.accessors[index], (4,))
        if values.dtype not in (np.uint8, np.uint16):
            raise self.accessors[index].error("joints must be unsigned integers of 8 or 16 bits")
        return values.astype(np.uint16)

    def weights(self, index: int) -> np.ndarray:
        """float32 (count, 4): weights of joints, none below 0. Raises SceneError."""
        values = self.vectors(index, 4)
        if values.min() < 0:
            raise self.accessors[index].error(f"it holds a negative weight, {values.min():g}")
        return values

    def matrices(self, index: int) -> np.ndarray:
        """float64 (count, 4, 4), acting on columns, last row 0 0 0 1. Raises SceneError."""
        matrices = self.vectors(index, 16).astype(np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)
        affine = np.isclose(matrices[:, 3], (0.0, 0.0, 0.0, 1.0), atol=1e-5).all(axis=1)
        if not affine.all():
            raise self.accessors[index].error(f"the last row of matrix {int(np.argmin(affine))} is not 0 0 0 1")
        matrices[:, 3] = (0.0, 0.0, 0.0, 1.0)
        return matrices

    def view(self, index: int) -> bytes:
        """The bytes of a buffer view. Raises SceneError."""
        return bytes(self._view(self.views[index])[0])

    def _view(self, fields: Fields) -> tuple[memoryview, int | None]:
        """A buffer view's bytes and its stride, None when tightly packed."""
        stride = fields.integer("byteStride", low=4, high=252) if "byteStride" in fields else None
        if compression(fields) is None:
            return self._stored(fields), stride
        if fields.place not in self._decompressed:
            self._decompressed[fields.place] = decompress(fields, self._stored, self.budget)
        return memoryview(self._decompressed[fields.place]), stride

    def _stored(self, fields: Fields) -> memoryview:
        """The bytes from `byteOffset` on of the buffer that a buffer view, or its compressed form, names."""
        number = fields.index("buffer", len(self.buffers), "buffer")
        if number is None:
            raise fields.error("'buffer' is missing")
        offset, length = fields.integer("byteOffset", 0), fields.integer("byteLength", low=1)
        if offset + length > len(self.buffers[number]):
            end = len(self.buffers[number])
            raise fields.error(f"bytes {offset} to {offset + length} are asked for, buffer {number} has {end}")
        return memoryview(self.buffers[number])[offset : offset + length]

    def _elements(self, fields: Fields, widths: tuple[int, ...]) -> np.ndarray:
        """The stored values (count, width), sparse ones put in place."""
        name = fields.string("type")
        if _WIDTHS.get(name) not in widths:
            allowed = " or ".join(kind for kind, width in _WIDTHS.items() if width in widths)
            raise fields.error(f"its type is {name}, must be {allowed} for what it is used as")
        width, count = _WIDTHS[name], fields.integer("count", low=1)
        dtype = _component(fields)
        sparse = fields.child("sparse")
        if fields.place in self._decoded:
            values = _converted(fields, self._decoded[fields.place], (count, width), dtype)
        elif "bufferView" in fields:
            values = self._strided(fields, count, width, dtype)
        elif count > _MOST_ZEROS:
            raise fields.error(f"it has {count} elements and no buffer view; at most {_MOST_ZEROS} are read")
        else:
            values = np.zeros((count, width), dtype)
        return self._with_sparse(sparse, values) if sparse else values

    def _strided(self, fields: Fields, count: int, width: int, dtype: np.dtype) -> np.ndarray:
        number = fields.index("bufferView", len(self.views), "bufferView")
        data, stride = self._view(self.views[number or 0])
        offset, element = fields.integer("byteOffset", 0), width * dtype.itemsize
        stride = stride or element
        if stride < element:
            raise fields.error(f"elements of {element} bytes do not fit a stride of {stride}")
        end = offset + (count - 1) * stride + element
        if end > len(data):
            raise fields.error(f"it needs {end} bytes, bufferView {number} has {len(data)}")
        return np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))

    def _with_sparse(self, sparse: Fields, values: np.ndarray) -> np.ndarray:
        count = sparse.integer("count", low=1, high=len(values))
        where, what = sparse.child("indices"), sparse.child("values")
        if where is None or what is None:
            raise sparse.error("it needs 'indices' and 'values'")
        for part in (where, what):
            if "bufferView" not in part:
                raise part.error("'bufferView' is missing")
        rows = self._strided(where, count, 1, _component(where, _UNSIGNED))[:, 0].astype(np.int64)
        if rows.max() >= len(values):
            raise where.error(f"index {rows.max()} of {len(values)} elements")
        result = values.copy()
        result[rows] = self._strided(what, count, values.shape[1], values.dtype)
        return result


def _component(fields: Fields, allowed: tuple[int, ...] = tuple(_COMPONENTS)) -> np.dtype:
    kind = fields.integer("componentType")
    if kind not in allowed:
        raise fields.error(f"componentType {kind} is none of {', '.join(map(str, allowed))}")
    return np.dtype(_COMPONENTS[kind]).newbyteorder("<")


def _converted(fields: Fields, values: np.ndarray, shape: tuple[int, int], dtype: np.dtype) -> np.ndarray:
    """Decoded values in the type and number that the accessor says."""
    if values.shape != shape:
        found, wanted = (" x ".join(map(str, size)) for size in (values.shape, shape))
        raise fields.error(f"its decoded data has {found} numbers, must have {wanted}")
    with np.errstate(invalid="ignore", over="ignore"):
        result = values.astype(dtype)
    if result.dtype.kind != "f" and (result != values).any():
        raise fields.error(f"its decoded data does not fit the type {dtype.name}")
    return result


def require(fields: Fields, index: int | None, what: str) -> int:
    """`index`, or SceneError that it is missing."""
    if index is None:
        raise fields.error(f"'{what}' is missing")
    return index
