"""Running the program and this package's children in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

_REPOSITORY = Path(__file__).resolve().parents[1]
_MINUTES = 5


def _run(words: list[str], folder: Path | None, seconds: float = 60.0 * _MINUTES) -> subprocess.CompletedProcess[str]:
    found = os.pathsep.join(filter(None, [str(_REPOSITORY), os.environ.get("PYTHONPATH")]))
    environment = {**os.environ, "PYTHONPATH": found}
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, timeout=seconds
    )


def octolux(
    *words: str | Path, folder: Path | None = None, seconds: float = 60.0 * _MINUTES
) -> subprocess.CompletedProcess[str]:
    """`octolux WORDS` in a process of its own, started in `folder`; SIGKILL and TimeoutExpired after `seconds`."""
    return _run(["-c", "from octolux.cli import main; main()", *map(str, words)], folder, seconds)


def child(module: str, *words: str | Path, seconds: float = 60.0 * _MINUTES) -> Any:
    """What `python -m benchmarks.MODULE WORDS` prints as JSON. Raises RuntimeError when it fails."""
    done = _run(["-m", f"benchmarks.{module}", *map(str, words)], _REPOSITORY, seconds)
    if done.returncode:
        raise RuntimeError(f"benchmarks.{module}: {done.stderr.strip()[-300:]}")
    return json.loads(done.stdout)
