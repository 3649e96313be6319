"""A small comparison that many tests look at."""

from __future__ import annotations

import pytest
from comparisons import LPV, SIZE, Dice
from gpu_tools import small_settings

import octolux
from octolux.compare import Report, compare
from octolux.techniques import TECHNIQUES


@pytest.fixture
def dice(monkeypatch) -> type[Dice]:
    """The technique `dice`, registered for one test; `thrown` tells what was rendered."""
    monkeypatch.setitem(TECHNIQUES, "dice", Dice)
    Dice.thrown.clear()
    return Dice


@pytest.fixture(scope="session")
def report(device) -> Report:
    """The Cornell box: a coarse uniform-lpv beside a finer one as the reference."""
    return compare(
        octolux.load("cornell-box"), [LPV], "uniform-lpv,n=32", size=SIZE, frames=2, device=device,
        frame_settings=small_settings(), command="octolux compare cornell-box </script> & so on",
    )  # fmt: skip
