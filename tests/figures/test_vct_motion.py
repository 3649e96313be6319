"""What moves, measured: figures of vct_motion at sizes that tests have time for."""

from __future__ import annotations

import pytest

from benchmarks import vct_motion


@pytest.fixture
def small(monkeypatch):
    for name, value in {"SCENE": "cornell-box", "DEPTH": 6, "WARM_UP": 0, "COUNT": 2}.items():
        monkeypatch.setattr(vct_motion, name, value)


def test_what_is_made_anew(small):
    """Part of it: how long that takes only idle machines tell."""
    light, thing = vct_motion.vct_moved_light(), vct_motion.vct_moved_object()
    assert 0.0 < light["spot.bricks"] < light["point.bricks"] <= 1.0 and min(light.values()) > 0.0
    assert 0.0 < thing["nodes"] < 0.2 and thing["ratio"] > 0.0


def test_a_circle_leaves_nothing():
    """The frames of two circles: other than each other within one, and the same in both."""
    run = vct_motion.long_run(2 * vct_motion.EARLY, size=(24, 18))
    once = vct_motion.EARLY
    assert len(set(run.pictures)) == once and run.pictures[:once] == run.pictures[once:-1]
    assert run.pictures[-1] == run.pictures[0]
    assert run.used[:once] == run.used[once:] and len(set(run.used)) > 1
    assert run.memory[once] == run.memory[-1]
