"""KHR_draco_mesh_compression: the accessors of a primitive, decoded by Google's library through DracoPy.

The library trusts the counts in the data's head and allocates by them. So these are read here first, and compared with
those of the accessors and with the budget (Draco bitstream specification, version 2.2).
"""

from __future__ import annotations

import DracoPy
import numpy as np

from .accessors import Accessors, require
from .json import Fields

_NAME = "KHR_draco_mesh_compression"
_REMEDY = "export the model again, or without Draco compression"
_MAGIC, _VERSION = b"DRACO", (2, 2)  # the one version that the extension allows
_MESH, _SEQUENTIAL, _EDGEBREAKER = 1, 0, 1
_METADATA = 0x80  # of the flags' upper byte
_TRIANGLES = 4  # the primitive's mode
_TRIANGLE_BYTES, _ATTRIBUTE_BYTES = 3 * 4, 4 * 4  # when decoded: three uint32; at most four float32


def decompressed(primitive: Fields, accessors: Accessors) -> Accessors:
    """`accessors`, with those that the primitive's Draco data fills decoded; the same object where it has none.

    Raises SceneError: broken data, attributes that are not in it, more elements than the accessors say.
    """
    extension = primitive.extension(_NAME)
    if extension is None:
        return accessors
    if primitive.integer("mode", _TRIANGLES) != _TRIANGLES:  # the extension allows strips too; no exporter writes them
        raise primitive.error("strips of triangles with Draco compression are not read", _REMEDY)
    mesh = _decode(extension, primitive, accessors)
    stored = {attribute["unique_id"]: attribute["data"] for attribute in mesh.attributes}
    attributes = primitive.child("attributes") or primitive
    decoded = {}
    for key, identifier in _identifiers(extension).items():
        index = require(attributes, attributes.index(key, len(accessors), "accessor"), key)
        if identifier not in stored:
            raise extension.error(f"{key} is attribute {identifier}, the Draco data has {sorted(stored)}", _REMEDY)
        decoded[index] = np.asarray(stored[identifier])
    decoded[_indices(primitive, accessors)] = np.asarray(mesh.faces).reshape(-1, 1)
    return accessors.with_decoded(decoded)


def _identifiers(extension: Fields) -> dict[str, int]:
    """The unique id in the Draco data of each attribute that is in it."""
    attributes = extension.child("attributes")
    if attributes is None:
        raise extension.error("'attributes' is missing")
    return {key: attributes.integer(key) for key in attributes.values}


def _decode(extension: Fields, primitive: Fields, accessors: Accessors) -> DracoPy.DracoMesh:
    data = accessors.view(require(extension, extension.index("bufferView", len(accessors.views), "bufferView"),
                                  "bufferView"))  # fmt: skip
    faces, points = _counts(extension, data)
    triangles, vertices = _announced(primitive, accessors)
    if faces > triangles or (points or 0) > vertices:
        problem = f"its Draco data has {faces} triangles and {points or '?'} vertices"
        raise extension.error(f"{problem}, the accessors have room for {triangles} and {vertices}", _REMEDY)
    attribute_bytes = vertices * _ATTRIBUTE_BYTES * len(_identifiers(extension))
    accessors.budget.take(extension, faces * _TRIANGLE_BYTES + attribute_bytes)
    try:
        mesh = DracoPy.decode(data)
    except Exception as error:  # the library raises kinds of its own, without a common one
        raise extension.error(f"its Draco data is broken ({error})", _REMEDY) from error
    if not isinstance(mesh, DracoPy.DracoMesh) or len(mesh.faces) != faces:
        raise extension.error("its Draco data holds no mesh of triangles", _REMEDY)
    return mesh


def _announced(primitive: Fields, accessors: Accessors) -> tuple[int, int]:
    """How many triangles and vertices the accessors of a primitive leave room for."""
    attributes = primitive.child("attributes") or primitive
    vertices = accessors.element_count(
        require(attributes, attributes.index("POSITION", len(accessors), "accessor"), "POSITION")
    )
    return accessors.element_count(_indices(primitive, accessors)) // 3, vertices


def _indices(primitive: Fields, accessors: Accessors) -> int:
    return require(primitive, primitive.index("indices", len(accessors), "accessor"), "indices")


def _counts(extension: Fields, data: bytes) -> tuple[int, int | None]:
    """The numbers of triangles and of points that Draco data announces; of points None where it does not say."""
    head = _Head(extension, data)
    magic = bytes(head.byte() for _ in _MAGIC)
    version = head.byte(), head.byte()
    if magic != _MAGIC or version != _VERSION:
        raise extension.error(f"it is no Draco data of version 2.2 but begins with {data[:7]!r}", _REMEDY)
    kind, method, _, flags = (head.byte() for _ in range(4))
    if kind != _MESH or method not in (_SEQUENTIAL, _EDGEBREAKER):
        raise extension.error("its Draco data holds no mesh of triangles", _REMEDY)
    if flags & _METADATA:
        head.skip_metadata()
    if method == _SEQUENTIAL:
        return head.varint(), head.varint()
    head.byte()  # the way of traversal
    head.varint()  # vertices before attributes split them
    return head.varint(), None


class _Head:
    """Reads the numbers at the head of Draco data."""

    def __init__(self, extension: Fields, data: bytes):
        self.extension, self.data, self.place = extension, data, 0

    def byte(self) -> int:
        if self.place >= len(self.data):
            raise self.extension.error("its Draco data ends within the header", _REMEDY)
        self.place += 1
        return self.data[self.place - 1]

    def varint(self) -> int:
        """Seven bits a byte, the lowest first; at most 32 bits."""
        value = 0
        for shift in range(0, 35, 7):
            byte = self.byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
        raise self.extension.error("a number in the header of its Draco data has no end", _REMEDY)

    def skip_metadata(self) -> None:
        """Passes names and values of attributes, then of the whole: each may have parts, which follow it."""
        for _ in range(self.varint()):
            self.varint()  # which attribute
            self._skip_element()
        self._skip_element()

    def _skip_element(self) -> None:
        parts, named = 1, False
        while parts:
            if named:
                self._skip(self.byte())
            for _ in range(self.varint()):
                self._skip(self.byte())
                self._skip(self.varint())
            parts += self.varint() - 1
            named = True

    def _skip(self, count: int) -> None:
        self.place += count
