"""What tests of comparisons share: a size, a technique of few cells, and one that draws samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from octolux.techniques.baselines import Constant, ConstantSettings
from octolux.techniques.settings import Settings, setting

SIZE = (48, 36)
LPV = "uniform-lpv,n=16,iterations=4"

_ANY: dict[str, Any] = {"unit": "", "allowed": [0, 1000], "cost": "none", "source": "tests"}


@dataclass(frozen=True)
class DiceSettings(Settings):
    """Of a technique whose whole picture is one throw of dice."""

    samples: int = setting(16, meaning="thrown", **_ANY)
    seed: int = setting(0, meaning="of the dice", **_ANY)


class Dice(Constant):
    """One irradiance of mean 1 with noise by seed and samples, as an unbiased estimator has."""

    name, summary, settings_class = "dice", "a constant with noise", DiceSettings
    thrown: list[tuple[int, int]] = []

    def __init__(self, device, settings):
        self.thrown.append((settings.samples, settings.seed))
        noise = np.random.default_rng(settings.seed).uniform(-0.5, 0.5) / np.sqrt(settings.samples)
        super().__init__(device, ConstantSettings(*[1.0 + noise] * 3))
        self.settings = settings
