"""Lets figures read and light voxels as the tests do: imported before `voxel_tools` and `voxel_scenes`."""

import sys
from pathlib import Path

TESTS = Path(__file__).parent.parent / "tests"
sys.path += [str(folder) for folder in (TESTS, TESTS / "kernels") if str(folder) not in sys.path]
