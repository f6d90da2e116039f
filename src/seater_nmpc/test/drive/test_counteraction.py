"""A chair whose castors hold it on another arc than it is asked for."""

import pytest
from driving import CHAIR

from seater_nmpc.control.actuation import Actuation
from seater_nmpc.drive.counteraction import Counteraction
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.parameters import Prediction

PERIOD, DELAY = 0.05, 3  # [s], cycles


def test_it_is_against_what_is_missing_and_bounded() -> None:
    counteraction = Counteraction()
    for difference, least, most in ((-0.09, 0.085, 0.095), (0.09, -0.095, -0.085), (-3.0, 0.24, 0.25)):
        for _ in range(40):
            counteraction.add(difference, PERIOD)
        assert least <= counteraction.value <= most
    counteraction.end()
    assert counteraction.value == 0.0


def test_what_any_castor_does_is_left_to_the_curvature() -> None:
    counteraction = Counteraction()
    for k in range(40):
        counteraction.add(0.03 * (-1) ** (k // 10), PERIOD)
    assert counteraction.value == 0.0


class StuckCastors:
    """They hold the chair on an arc until the motors, which build up force by what is missing, have turned them."""

    def __init__(self, curvature: float, holds: float) -> None:
        """`holds` [rad]: of rates that are missing, added up."""
        self.omega, self._curvature, self._holds, self._force = 0.0, curvature, holds, 0.0

    def drive(self, v: float, omega: float) -> None:
        self._force += (omega - self._curvature * v) * PERIOD
        held = abs(self._force) < self._holds
        self.omega = self._curvature * v if held else self.omega + (omega - self.omega) * PERIOD / 0.2


def seconds_held(wanted: float, curvature: float, counteracts: bool, monkeypatch: pytest.MonkeyPatch) -> float:
    """Until a chair at 0.15 m/s turns as it is asked to."""
    if not counteracts:
        monkeypatch.setattr(Counteraction, "add", lambda *_: None)
    actuation = Actuation(CHAIR, CommandHistory(Prediction()), adapt=True)
    chair, commands = StuckCastors(curvature, 0.35), [(0.15, 0.0)] * DELAY
    for k in range(100):
        commands.append(actuation.send(PERIOD * k, (0.15, wanted), (0.15, chair.omega), PERIOD, True))
        chair.drive(*commands[k])
        actuation.measured(PERIOD * (k + 1), 0.15, chair.omega)
        if chair.omega * wanted > 0.0 and abs(chair.omega - wanted) < 0.3 * abs(wanted):
            return PERIOD * k
    return 5.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_castors_that_hold_a_chair_on_an_arc_are_turned_sooner(sign: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tester's stiff castors: the chair wove by 8 deg on the straight and stood 2 to 8 deg beside the dock."""
    quick = seconds_held(0.08 * sign, -0.4 * sign, True, monkeypatch)
    plain = seconds_held(0.08 * sign, -0.4 * sign, False, monkeypatch)
    assert quick < 0.8 * plain and quick < 1.7
