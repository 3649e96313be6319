"""Reading the files that a scene names."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path


class NotAFile(OSError):
    """A device or a pipe."""


def read_file(path: Path) -> bytes:
    """What a file holds.

    Raises OSError, also where the name is that of a device or a pipe, for what a scene names may not be read for ever
    ("/dev/zero"); ValueError for a name with a zero byte.
    """
    check_ordinary(path)
    return path.read_bytes()


def check_ordinary(path: Path) -> None:
    """Raises NotAFile when it is neither a file nor a folder, OSError when it is not there."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
        raise NotAFile(errno.EINVAL, "it is a device or a pipe, not a file", os.fspath(path))
