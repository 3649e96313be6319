"""What has been made of images, kept between runs: files in the user's cache folder, named after the content.

`OCTOLUX_CACHE` names another folder, or is `off`. Whatever goes wrong with the cache (no room, no permission, files
damaged, deleted or written by another process meanwhile) means that a thing is made anew; nothing is reported.
"""

from __future__ import annotations

import hashlib
import os
import struct
import tempfile
import threading
import zlib
from contextlib import suppress
from pathlib import Path

import platformdirs

MOST_BYTES = 2 << 30
_TRIM_AFTER = MOST_BYTES // 16  # written by this process; so far the folder may outgrow its bound
# Counts up when what is stored, or how it is made, changes.
_VERSION = 1
_HEADER = struct.Struct("<8sIQ")  # magic, CRC-32 and length of what follows
_MAGIC = b"octolux\n"
_lock = threading.Lock()
_written = _TRIM_AFTER  # the first write looks at the folder's size


def cache_folder() -> Path | None:
    """Where the cache is, or None when it is turned off."""
    named = os.environ.get("OCTOLUX_CACHE", "")
    if named.lower() == "off":
        return None
    return Path(named) if named else platformdirs.user_cache_path("octolux", appauthor=False)


def content_key(*parts: bytes | str) -> str:
    """A name for what is made of `parts`; "" when one of them is "", which has no name."""
    digest = hashlib.blake2b(f"{_VERSION}".encode(), digest_size=20)
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        if not data:
            return ""
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    return digest.hexdigest()


def is_known_good(key: str) -> bool:
    """Whether the file with this content has been decoded before, without fault."""
    folder = cache_folder()
    return folder is not None and (folder / f"{key}.good").exists()


def remember_good(key: str) -> None:
    """Note that the file with this content can be decoded."""
    folder = cache_folder()
    if folder is not None:
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{key}.good").touch()


def read(name: str, length: int) -> memoryview | None:
    """The `length` bytes kept under `name`; None when there are none, or they are not what was written."""
    folder = cache_folder()
    if folder is None:
        return None
    path = folder / name
    try:
        stored = path.read_bytes()
        os.utime(path)  # the oldest go first, by their last use
    except OSError:
        return None
    if len(stored) != _HEADER.size + length:
        return None
    kept = memoryview(stored)[_HEADER.size :]
    return kept if stored[: _HEADER.size] == _HEADER.pack(_MAGIC, zlib.crc32(kept), length) else None


def write(name: str, data: bytes) -> None:
    """Keep `data` under `name`. The file appears whole or not at all."""
    folder = cache_folder()
    if folder is None:
        return
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(suffix=".part", dir=folder)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(_HEADER.pack(_MAGIC, zlib.crc32(data), len(data)))
                file.write(data)
            os.replace(temporary, folder / name)
        except OSError:
            Path(temporary).unlink(missing_ok=True)
            raise
        _trim_at_times(folder, len(data))


def _trim_at_times(folder: Path, size: int) -> None:
    global _written
    with _lock:
        _written += size
        if _written >= _TRIM_AFTER:
            _written = 0
            trim(folder)


def trim(folder: Path, most_bytes: int = MOST_BYTES) -> None:
    """Delete the files of the folder that were used longest ago, until the rest has at most `most_bytes`."""
    files = []
    for entry in os.scandir(folder):
        with suppress(OSError):  # deleted by another process meanwhile
            about = entry.stat()
            files.append((about.st_mtime_ns, about.st_size, entry.path))
    excess = sum(size for _, size, _ in files) - most_bytes
    for _, size, path in sorted(files):
        if excess <= 0:
            return
        with suppress(OSError):
            os.unlink(path)
            excess -= size
