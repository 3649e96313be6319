"""The one error that a wrong action raises."""

from octolux.scene.errors import OctoluxError


class SimulationError(OctoluxError):
    """An action, name or number the laboratory cannot take.

    problem: what is wrong; remedy: what to give instead; both as sentences without a full stop.
    """

    def __init__(self, problem: str, remedy: str):
        self.problem, self.remedy = problem, remedy
        super().__init__(f"{problem}. {remedy[0].upper()}{remedy[1:]}.")
