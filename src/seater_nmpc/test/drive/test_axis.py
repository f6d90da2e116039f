"""What one axis makes of a command, and which command asks for a speed."""

import pytest

from seater_nmpc.drive.axis import AxisDrive, configured
from seater_nmpc.parameters import Prediction

KINDS = [AxisDrive(0.9, 0.05, offset) for offset in (False, True)]


@pytest.mark.parametrize("drive", [*KINDS, AxisDrive(1.2)], ids=["jump", "offset", "no deadband"])
def test_a_command_brings_about_the_speed_that_it_was_chosen_for(drive) -> None:
    for speed in (1.001 * drive.smallest_speed + 1e-6, 0.1, 0.5):
        assert drive.effective(drive.command(speed)) == pytest.approx(speed, abs=1e-12)
        assert drive.effective(drive.command(-speed)) == pytest.approx(-speed, abs=1e-12)
    assert drive.command(0.0) == drive.effective(0.0) == 0.0


def test_beyond_its_deadband_a_jump_acts_in_full_and_an_offset_is_taken_off() -> None:
    jump, offset = KINDS
    assert jump.effective(0.1) == pytest.approx(0.09) and offset.effective(0.1) == pytest.approx(0.045)
    assert jump.effective(-0.1) == pytest.approx(-0.09) and offset.effective(-0.1) == pytest.approx(-0.045)
    for drive in KINDS:
        assert drive.effective(0.05) == drive.effective(-0.03) == 0.0


@pytest.mark.parametrize("drive", KINDS, ids=["jump", "offset"])
def test_speeds_that_cannot_be_had_ask_for_the_smallest_sure_command(drive) -> None:
    """A quarter beyond the deadband, in either direction."""
    for speed in (1e-9, 0.5 * drive.smallest_speed):
        assert drive.command(speed) == pytest.approx(0.0625) and drive.command(-speed) == pytest.approx(-0.0625)
        assert drive.effective(drive.command(speed)) == pytest.approx(drive.smallest_speed)
    assert AxisDrive(1.2).smallest_speed == 0.0


def test_what_is_configured() -> None:
    drive = configured(Prediction(motor_lag=0.3, gain_omega=0.8, deadband_v=0.02))
    assert (drive.v, drive.omega) == (AxisDrive(1.0, 0.02), AxisDrive(0.8, 0.0))
    assert (drive.lag_v, drive.lag_omega, drive.curvature) == (0.3, 0.3, 0.0)
    assert configured(Prediction(motor_lag_turning=0.1)).lag_omega == 0.1
