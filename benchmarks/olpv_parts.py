"""The eleven parts that OLPV's table 1 times, by the names of passes and buffers."""

from __future__ import annotations

PARTS = ("Frame", "RSMCreate", "GVClear", "GVInject", "GVDownsample", "IXClear", "LPVClear", "LPVInject",
         "LPVDownsample", "LPVPropagate", "LPVMerge")  # fmt: skip
CLEAR_TO_MERGE = PARTS[2:]
OTHER = "other"
"""What the thesis does not time: the G-buffer, direct light, lookup, composite."""

_CLEARED = {"LPV geometry volume": "GVClear", "LPV index volume": "IXClear"}
# The first step of propagation reads injected light, and the sum begins with it and the index with its marks: no pass
# does that alone. `volumes` is the uniform volume's copy for the texture unit, which the octree's merge writes itself.
_STAGES = {"RSM rendering": "RSMCreate", "RSM surfaces": "RSMCreate", "geometry volume": "GVInject",
           "injection": "LPVInject", "downsampling": "LPVDownsample", "propagation": "LPVPropagate",
           "merge": "LPVMerge", "volumes": "LPVMerge"}  # fmt: skip


def part_of(stage: str, name: str, clears: bool = False) -> str:
    """The part that a pass, or the clearing of a buffer, of that name in that stage belongs to."""
    if clears and name.startswith("LPV"):
        return _CLEARED.get(name, "LPVClear")
    if (stage, name) == ("geometry volume", "downsample"):
        return "GVDownsample"
    return _STAGES.get(stage, OTHER)
