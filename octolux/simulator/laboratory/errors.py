"""The one error that a wrong action raises."""

from octolux.scene.errors import OctoluxError


class SimulationError(OctoluxError):
    """An action, name or number the laboratory cannot take; the text says what to give instead."""
