"""The offline laboratory: octree light propagation, one action at a time, for one colour channel (Olovsson 2012, 5.1).

Float64 NumPy throughout. Lengths are in cells of level 0; an SH array is [z][y][x][4], radiant intensity, W/sr (cd).
`Simulation` is the way in; docs/simulate.md tells how it is used from the command line.
"""

from .errors import SimulationError
from .injectors import Area, Element, FromArray, Wall, from_file
from .propagators import PROPAGATORS, Propagator
from .simulation import Simulation
from .state import State

__all__ = [
    "PROPAGATORS", "Area", "Element", "FromArray", "Propagator", "Simulation", "SimulationError", "State", "Wall",
    "from_file",
]  # fmt: skip
