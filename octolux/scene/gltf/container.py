"""glTF files as bytes: .gltf and .glb, their buffers, and the URIs by which they name other files."""

from __future__ import annotations

import base64
import binascii
import struct
from pathlib import Path
from urllib.parse import unquote

from ..errors import SceneError
from ..files import read_file
from .json import Fields, parse
from .meshopt import is_fallback

_JSON, _BIN = 0x4E4F534A, 0x004E4942


def read_container(path: Path) -> tuple[Fields, bytes | None]:
    """The JSON root of a .gltf or .glb file, and the binary chunk of the latter (glTF 2.0, section 4.4).

    Which of the two it is, is told from the content. Raises SceneError.
    """
    try:
        content = read_file(path)
    except OSError as error:
        remedy = "check the path and the permissions"
        raise SceneError(path, "", f"cannot be read: {error.strerror}", remedy) from error
    if not content:
        raise SceneError(path, "", "the file is empty", "export the model again")
    if path.suffix.lower() != ".glb" and content[:4] != b"glTF":
        return parse(path, content), None
    chunks = _chunks(path, content)
    return parse(path, chunks[_JSON]), chunks.get(_BIN)


def _chunks(path: Path, content: bytes) -> dict[int, bytes]:
    def error(place: str, problem: str) -> SceneError:
        return SceneError(path, place, problem, "copy the file again, or export the model again as GLB 2.0")

    if content[:4] != b"glTF":
        raise error("header", f"a GLB file begins with 'glTF', this one with {content[:4]!r}")
    if len(content) < 20:
        raise error("header", f"the file ends after {len(content)} bytes, within its header")
    version, length = struct.unpack_from("<II", content, 4)
    if version != 2:
        raise error("header", f"GLB version {version} is not supported")
    if length > len(content):
        raise error("header", f"the file says it has {length} bytes and has {len(content)}")
    chunks: dict[int, bytes] = {}
    start, number = 12, 0
    while start < length:
        if start + 8 > length:
            raise error(f"chunk {number}", "the file ends within the chunk's header")
        size, kind = struct.unpack_from("<II", content, start)
        if start + 8 + size > length:
            raise error(f"chunk {number}", f"it says it has {size} bytes, {length - start - 8} are left")
        if number == 0 and kind != _JSON:
            raise error("chunk 0", "the first chunk is not JSON")
        chunks.setdefault(kind, content[start + 8 : start + 8 + size])
        start, number = start + 8 + size, number + 1
    if _JSON not in chunks:
        raise error("header", "the file ends before its first chunk")
    return chunks


def read_uri(fields: Fields, uri: str) -> bytes | Path:
    """What a `uri` names: the bytes of a data URI, or the path of a file, which may not exist. Raises SceneError."""
    if uri.startswith("data:"):
        head, comma, data = uri.partition(",")
        if not comma or not head.endswith(";base64"):
            raise fields.error("its data URI is not base64")
        try:
            return base64.b64decode(unquote(data), validate=True)
        except (binascii.Error, ValueError) as error:
            raise fields.error(f"its data URI is broken ({error})") from error
    if "://" in uri:
        raise fields.error(f"'{uri[:80]}' lies on the network", "download it beside the file and name it there")
    if "\0" in uri or not uri:
        raise fields.error("its 'uri' is no file name")
    plain = fields.file.parent / uri
    return plain if _exists(plain) else fields.file.parent / unquote(uri)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # a name longer than the file system allows
        return False


def read_buffers(root: Fields, binary: bytes | None) -> list[bytes]:
    """All buffers, each checked to have its declared length; those that only stand in for compressed data are empty."""
    return [_buffer(fields, number, binary) for number, fields in enumerate(root.children("buffers", "buffer"))]


def _buffer(fields: Fields, number: int, binary: bytes | None) -> bytes:
    length = fields.integer("byteLength", low=1)
    if is_fallback(fields):
        return b""
    if "uri" in fields:
        data = read_uri(fields, fields.string("uri"))
    elif number == 0 and binary is not None:
        data = binary
    else:
        raise fields.error("it has neither a 'uri' nor a binary chunk")
    if isinstance(data, Path):
        path = data
        try:
            data = read_file(path)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise fields.error(f"'{path}' cannot be read: {reason}", "put the file there") from error
    if len(data) < length:
        raise fields.error(f"it says it has {length} bytes and has {len(data)}")
    return data
