"""A grid of triangles for tests of compression, errors of broken models, and what changed bytes do to loading."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.gltf.loader import load_gltf

SIDE = 7
Y, X = (axis.ravel() for axis in np.mgrid[0:SIDE, 0:SIDE])
POSITIONS = np.column_stack([X, Y, (X * Y) % 3]).astype(np.float32)
UVS = np.column_stack([X, Y]).astype(np.float32) / 8
FIRST = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
TRIANGLES = np.concatenate(
    [np.column_stack([FIRST, FIRST + 1, FIRST + SIDE]), np.column_stack([FIRST + 1, FIRST + SIDE + 1, FIRST + SIDE])]
).astype(np.uint32)


def corners(positions, triangles) -> list:
    """The triangles by the places of their corners, whichever triangle, corner or vertex comes first."""
    listed = np.asarray(positions, np.float64)[triangles].round(3).tolist()
    return sorted(min(triangle[turn:] + triangle[:turn] for turn in range(3)) for triangle in listed)


def error_of(path) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_gltf(path)
    assert caught.value.remedy
    return caught.value


# Loads copies of a model with bytes changed; prints how many loads ended how. 2 GiB of address space beyond what the
# imports take is the most that any may use: allocations above it fail and would be a MemoryError, not a SceneError.
MUTATE = """
import random, sys
from collections import Counter
from pathlib import Path

from octolux.scene.errors import SceneError
from octolux.scene.gltf.loader import load_gltf

model, target, first, last = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
if sys.platform == "linux":
    import resource
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + (2 << 30),) * 2)
good, chance, ends = target.read_bytes(), random.Random(7), Counter()
for _ in range(400):
    data = bytearray(good)
    for _ in range(chance.choice((1, 1, 2, 5))):
        place = chance.randrange(first, last)
        data[place] = chance.choice((chance.randrange(256), 255, data[place] ^ 1 << chance.randrange(8)))
    target.write_bytes(data)
    try:
        load_gltf(model)
        ends["loaded"] += 1
    except SceneError:
        ends["refused"] += 1
print(ends["loaded"], ends["refused"])
"""


def outcomes(model: Path, target: Path, part: slice) -> tuple[int, int]:
    command = [sys.executable, "-c", MUTATE, str(model), str(target), str(part.start), str(part.stop)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    loaded, refused = map(int, done.stdout.split())
    return loaded, refused
