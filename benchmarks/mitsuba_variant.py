"""Mitsuba's LLVM variant, where it is installed: what the path tracer and the BVH are measured beside."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path
from typing import Any

from .registry import NeedsData


def mitsuba() -> Any:
    """The module, its LLVM variant chosen. It takes as many threads as the machine has cores.

    Raises NeedsData where Mitsuba or an LLVM that it runs with is missing: with others it ends the process.
    """
    if "DRJIT_LIBLLVM_PATH" not in os.environ:
        packaged = sorted((Path(sys.prefix) / "lib").glob("libLLVM.so.*"))
        if not packaged:
            raise NeedsData("Mitsuba's LLVM: pip install 'octolux[reference]'")
        os.environ["DRJIT_LIBLLVM_PATH"] = str(packaged[-1])
    if importlib.util.find_spec("mitsuba") is None:
        raise NeedsData("Mitsuba: pip install 'octolux[reference]'")
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    return mi
