"""EXT_meshopt_compression and KHR_meshopt_compression: buffer views, decoded by meshoptimizer through `meshopt`.

The two are alike; the newer one has the filter COLOR besides. What decoders are asked to allocate is bounded first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import meshopt

from .json import Fields

NAMES = ("EXT_meshopt_compression", "KHR_meshopt_compression")
_REMEDY = "export the model again, or without meshopt compression"
_MODES = ("ATTRIBUTES", "TRIANGLES", "INDICES")
_FILTER_STRIDES: dict[str, tuple[int, ...]] = {
    "NONE": tuple(range(4, 257, 4)),
    "OCTAHEDRAL": (4, 8),
    "QUATERNION": (8,),
    "EXPONENTIAL": tuple(range(4, 257, 4)),
    "COLOR": (4, 8),
}


class Budget:
    """How many bytes decoders of compressed meshes may still make for one file.

    Their formats can make any number from a few: a meshopt block of 256 elements may be two bits for each of their
    bytes, and arithmetic coding in Draco has no limit at all. At the 20 bytes that a packed vertex takes, PART holds
    six million vertices and WHOLE 25 million, more than octolux can draw.
    """

    PART = 1 << 27  # of one buffer view, or one primitive
    WHOLE = 1 << 29  # of one file

    def __init__(self) -> None:
        self.left = self.WHOLE

    def take(self, fields: Fields, size: int) -> None:
        """Note that `size` bytes are made for what `fields` describes. Raises SceneError when it is too much."""
        if size > min(self.PART, self.left):
            most = f"at most {self.PART >> 20} MiB are read in one piece and {self.WHOLE >> 20} MiB from a file"
            raise fields.error(f"it says it holds {size} bytes when decompressed; {most}", "split the model")
        self.left -= size


def compression(view: Fields) -> Fields | None:
    """What says how a buffer view is compressed; None where it is not."""
    return next((found for name in NAMES if (found := view.extension(name))), None)


def is_fallback(buffer: Fields) -> bool:
    """Whether a buffer only stands in for compressed data, where a loader knows nothing of it."""
    extension = compression(buffer)
    return extension is not None and extension.boolean("fallback", False)


def decompress(view: Fields, stored: Callable[[Fields], memoryview], budget: Budget) -> bytes:
    """The bytes of a compressed buffer view.

    stored: gives the compressed bytes that the extension names. Raises SceneError: modes, filters, strides and counts
    that the extension does not allow, broken data, more than the budget holds.
    """
    fields = cast(Fields, compression(view))
    mode, name = fields.string("mode"), fields.string("filter", "NONE")
    stride, count = fields.integer("byteStride", low=2, high=256), fields.integer("count", low=1)
    _check(fields, mode, name, stride, count)
    if view.integer("byteLength", low=1) != stride * count:
        raise view.error(f"'byteLength' is not that of {count} elements of {stride} bytes", _REMEDY)
    if view.integer("byteStride", stride) != stride:
        raise view.error(f"'byteStride' differs from the {stride} of its compressed form", _REMEDY)
    data = bytes(stored(fields))
    budget.take(fields, stride * count)
    try:
        return meshopt.decode_gltf_buffer(data, count, stride, mode, None if name == "NONE" else name).tobytes()
    except ValueError as error:
        raise fields.error(f"its data is broken ({error})", _REMEDY) from error


def _check(fields: Fields, mode: str, name: str, stride: int, count: int) -> None:
    if mode not in _MODES:
        raise fields.error(f"'mode' is '{mode}', must be one of {', '.join(_MODES)}", _REMEDY)
    if name not in _FILTER_STRIDES:
        raise fields.error(f"'filter' is '{name}', must be one of {', '.join(_FILTER_STRIDES)}", _REMEDY)
    if mode != "ATTRIBUTES" and name != "NONE":
        raise fields.error(f"the filter {name} is not for mode {mode}", _REMEDY)
    strides = _FILTER_STRIDES[name] if mode == "ATTRIBUTES" else (2, 4)
    if stride not in strides:
        raise fields.error(f"'byteStride' is {stride}, which mode {mode} with filter {name} does not have", _REMEDY)
    if mode == "TRIANGLES" and count % 3:
        raise fields.error(f"'count' is {count}, which makes no whole triangles", _REMEDY)
