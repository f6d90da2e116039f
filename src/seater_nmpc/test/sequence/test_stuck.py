"""Gets nowhere: standing, or to and fro on the same spot."""

import numpy as np
import pytest

from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.standstill import Standstill


def got_nowhere(way) -> float:
    """When a chair that is at way(t) is first called stuck [s]; inf: never within 20 s."""
    standstill = Standstill(SequenceParameters(stall_time=4.0), 0.0)
    times = np.arange(0.0, 20.0, 0.05)
    return next((float(t) for t in times if standstill.stuck(float(t), way(float(t)))), np.inf)


@pytest.mark.parametrize(
    "way",
    [lambda t: np.zeros(3), lambda t: np.array([0.02 * np.sin(5.0 * t), 0.0, 3.1 + 0.06 * np.sin(4.0 * t)])],
    ids=["standing", "to and fro across the heading of pi"],
)
def test_a_chair_that_stays_on_the_spot_is_stuck_after_the_stall_time(way) -> None:
    assert got_nowhere(way) == pytest.approx(4.05, abs=0.06)


@pytest.mark.parametrize(
    "way",
    [lambda t: np.array([0.02 * t, 0.0, 0.0]), lambda t: np.array([0.0, 0.0, 0.06 * t])],
    ids=["driving slowly", "turning slowly"],
)
def test_a_slow_one_is_not(way) -> None:
    assert got_nowhere(way) == np.inf
