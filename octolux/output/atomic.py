"""Files that appear whole or not at all, also after a power cut or `kill -9`.

A file is written under a temporary name in its own folder, flushed to the disk, and renamed. As long as its writer
lives it holds a lock on the temporary file; the system drops the lock with the process, so a temporary file without
one is a leftover. On Windows the open file is the lock: it cannot be deleted.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..scene.errors import OctoluxError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_MARK = ".octolux-"


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path to write to; it becomes `path` when the block ends, and goes away when it raises.

    Raises OctoluxError, with `path` as it was, when the file cannot be written (OSError inside the block too).
    """
    try:
        handle, name = _locked_temporary(path)
    except OSError as error:
        raise OctoluxError(f"{path}: cannot be written: {error.strerror or error}. Choose another folder.") from error
    try:
        yield Path(name)
        os.fsync(handle)  # of the file, whoever wrote to it
        os.chmod(name, 0o666 & ~_umask())  # mkstemp's files are private
        if fcntl is None:
            handle = _closed(handle)
        os.replace(name, path)
        _flush_folder(path.parent)
    except OSError as error:
        raise OctoluxError(f"{path}: cannot be written: {error.strerror or error}. Is the disk full?") from error
    finally:
        _closed(handle)
        Path(name).unlink(missing_ok=True)


def remove_leftovers(folder: Path) -> int:
    """Delete the temporary files in `folder` whose writers were killed; returns how many there were."""
    return sum(map(_remove_leftover, folder.glob(f"{_MARK}*")))


def _locked_temporary(path: Path) -> tuple[int, str]:
    while True:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f"{_MARK}{path.stem[:32]}-", suffix=path.suffix)
        _lock(handle)
        if os.path.exists(name):  # else another run took it for a leftover before it was locked
            return handle, name
        os.close(handle)


def _lock(handle: int) -> bool:
    """Whether the file is now locked by us. Some network folders have no locks; their leftovers stay."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove_leftover(path: Path) -> bool:
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:  # finished, or removed by another run, in this moment
        return False
    try:
        if fcntl is None:
            handle = _closed(handle)  # an open file could not be deleted
        elif not _lock(handle):
            return False
        path.unlink()
    except OSError:
        return False
    finally:
        _closed(handle)
    return True


def _closed(handle: int) -> int:
    """Close the file unless it is closed; returns what stands for no file."""
    if handle >= 0:
        os.close(handle)
    return -1


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _flush_folder(folder: Path) -> None:
    """Make the rename itself last. Windows cannot open folders, and need not."""
    if fcntl is None:
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
