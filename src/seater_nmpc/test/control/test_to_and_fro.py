"""Ways to and fro that are too short to turn the castors round for are left out."""

from __future__ import annotations

import numpy as np
import pytest

from seater_nmpc.control.to_and_fro import ToAndFro
from seater_nmpc.programme import Plan

STEP = 0.1  # [s]


def plan(*speeds: float) -> Plan:
    """With these speeds [m/s], 0.1 s apart."""
    states = np.zeros((len(speeds), 5))
    states[:, 3] = speeds
    return Plan(times=STEP * np.arange(len(speeds)), states=states, violation=0.0, speeds_held=False)


MERE = plan(0.0, -0.05, -0.05, 0.0, 0.2, 0.4, 0.5)  # 1 cm back, then ahead


@pytest.mark.parametrize("before", [0.0, 0.1], ids=["standing", "driving ahead"])
def test_a_centimetre_back_before_a_way_ahead_is_left_out_for_a_while(before: float) -> None:
    leaves_out = ToAndFro()
    assert leaves_out.speed(0.0, MERE, -0.03, before) == 0.0 == leaves_out.speed(1.9, MERE, -0.03, 0.0)
    assert leaves_out.speed(2.0, MERE, -0.03, 0.0) == -0.03  # a corner may be in the way
    assert leaves_out.speed(2.1, MERE, -0.03, -0.03) == -0.03
    assert leaves_out.speed(2.2, MERE, -0.03, 0.0) == 0.0


@pytest.mark.parametrize(
    ("speeds", "v", "before"),
    [
        ((0.0, -0.2, -0.3, -0.2, 0.0, 0.3, 0.5, 0.5, 0.5), -0.1, 0.0),  # 7 cm back
        ((0.0, -0.05, -0.05, 0.0, 0.0, 0.0, 0.0), -0.03, 0.0),  # back to where it stays
        ((0.0, -0.05, -0.05, 0.0, 0.01, 0.01, 0.0), -0.03, 0.0),  # and hardly ahead
        ((-0.2, -0.05, 0.0, 0.2, 0.4, 0.5, 0.5), -0.12, -0.2),  # the end of a way back
        ((0.0, 0.2, 0.4, 0.5, 0.5, 0.5, 0.5), 0.1, 0.0),
        ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0, 0.1),
    ],
)
def test_what_is_worth_while_is_driven(speeds: tuple[float, ...], v: float, before: float) -> None:
    assert ToAndFro().speed(0.0, plan(*speeds), v, before) == v
