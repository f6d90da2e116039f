"""The corridor into the bay: how fast a chair may come that would not pass it yet."""

from __future__ import annotations

import math

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.plan.corridor import Corridor

CORRIDOR, GATE = Corridor(Chair(), Dock(), SequenceParameters()), -0.85  # [m]


def speed(ahead: float, y: float, heading: float, reaction: float = 0.5) -> float:
    """[m/s] so far [m] ahead of the gate."""
    return CORRIDOR.speed(np.array([GATE - ahead, y, heading]), reaction)


def test_a_chair_that_would_not_pass_has_four_of_its_reaction_times_left() -> None:
    assert speed(0.6, 0.0, 0.2) == speed(0.6, 0.07, 0.0) == pytest.approx(0.3)
    assert speed(0.6, 0.0, -0.2, reaction=1.0) == pytest.approx(0.15)
    assert speed(0.01, 0.0, 0.2) == pytest.approx(0.12)  # it gets on


def test_one_that_passes_is_not_slowed_down() -> None:
    assert speed(0.3, 0.03, 0.07) == math.inf
    assert speed(-0.01, 0.0, 0.3) == math.inf  # it is past the gate
