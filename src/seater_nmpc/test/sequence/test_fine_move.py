"""One small move of a standing chair: how far it goes, in which direction, and what the next one learns from it."""

import numpy as np
import pytest

from seater_common.geometry import Chair
from seater_nmpc.drive.axis import AxisDrive, ChairDrive
from seater_nmpc.sequence.fine_move import FineMove

LIMITS, PERIOD = Chair().limits, 0.05
DRIVES = {
    "no deadband": AxisDrive(),
    "gain": AxisDrive(0.8),
    "jump": AxisDrive(1.0, 0.04),
    "offset": AxisDrive(1.0, 0.04, True),
}


def chair(axis: AxisDrive) -> ChairDrive:
    return ChairDrive(axis, axis, 0.2, 0.2)


def carry_out(move, axis: AxisDrive, resistance: float = 0.0, seconds: float = 5.0) -> tuple[float, list[float]]:
    """Way or turn of the chair, and the speeds that were asked for, until the move is over."""
    done, asked = 0.0, []
    for _ in range(round(seconds / PERIOD)):
        speeds = move.speeds(PERIOD)
        if speeds is None:
            return done, asked
        assert speeds[0 if move.turning else 1] == 0.0  # straight or on the spot
        asked.append(speeds[1 if move.turning else 0])
        speed = axis.effective(axis.command(asked[-1])) if abs(asked[-1]) >= axis.smallest_speed else 0.0
        done += np.sign(speed) * max(0.0, abs(speed) - resistance) * PERIOD
    pytest.fail("the move does not end")


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("turning", [False, True], ids=["straight", "turning"])
def test_the_area_of_a_move_is_the_error(name: str, turning: bool) -> None:
    """To within what the smallest speed drives in half a cycle, from small errors to the largest ones."""
    axis, largest = DRIVES[name], 0.12 if turning else 0.03
    for size in np.linspace(0.1 * largest, largest, 10):
        for error in (size, -size):
            move = FineMove(np.array([error, 0.002, error]), turning, chair(axis), LIMITS)
            done, asked = carry_out(move, axis)
            fastest = max(abs(speed) for speed in asked)
            assert done == pytest.approx(-error, abs=0.5 * fastest * PERIOD + 1e-9)
            assert all(speed * error < 0.0 for speed in asked)
            rate = LIMITS.alpha_max if turning else LIMITS.a_max
            assert np.max(np.abs(np.diff([0.0, *asked]))) <= rate * PERIOD + 1e-9
            assert fastest <= max(0.35 if turning else 0.08, axis.smallest_speed) and len(asked) * PERIOD <= 1.0


def test_without_an_error_nothing_moves() -> None:
    assert FineMove(np.array([0.0, 0.004, 0.05]), False, chair(AxisDrive()), LIMITS).speeds(PERIOD) is None
    assert FineMove(np.array([0.01, 0.004, 0.0]), True, chair(AxisDrive()), LIMITS).speeds(PERIOD) is None


def in_series(resistance: float, error: float, moves: int) -> list[float]:
    """Errors left after each of several moves in turning, on castors that hold against them so much."""
    axis, before, left = AxisDrive(), None, [error]
    for _ in range(moves):
        before = FineMove(np.array([0.0, 0.0, left[-1]]), True, chair(axis), LIMITS, before)
        left.append(left[-1] + carry_out(before, axis, resistance)[0])
    return left


def test_the_resistance_is_learned_from_how_far_the_last_move_got() -> None:
    """Against 0.06 rad/s the first move of 1.7 deg comes short by half; the third one comes within 0.15 deg."""
    left = in_series(0.06, -0.03, 4)
    assert abs(left[1]) > 0.01 and abs(left[3]) < 0.0026
    free = in_series(0.0, -0.03, 1)
    assert abs(free[1]) < 0.003


def after(error: float, left: float, turning: bool = True) -> float:
    """Resistance that a move reckons with, after one that made `error` in turning to `left`."""
    first = FineMove(np.array([error, 0.0, error]), True, chair(AxisDrive()), LIMITS)
    carry_out(first, AxisDrive())
    return FineMove(np.array([left, 0.0, left]), turning, chair(AxisDrive()), LIMITS, first).resistance


def test_nothing_is_learned_for_another_direction_or_axis() -> None:
    assert 0.01 < after(0.03, 0.02) <= 0.1
    assert after(0.03, -0.02) == after(0.03, 0.02, turning=False) == 0.0
    assert after(0.03, 0.0) == 0.0
    assert after(0.12, 0.12) == 0.1  # did not move at all: from move to move it grows by so much at most


def test_what_was_learned_of_turning_outlives_a_straight_move() -> None:
    """On castors the two alternate: a turn on the spot, some millimetres ahead, the rest of the turn."""
    drive, held = chair(AxisDrive()), 0.06
    turn = FineMove(np.array([-0.01, 0.0, 0.03]), True, drive, LIMITS)
    left = 0.03 + carry_out(turn, AxisDrive(), held)[0]
    straight = FineMove(np.array([-0.01, 0.0, left]), False, drive, LIMITS, turn)
    carry_out(straight, AxisDrive())
    again = FineMove(np.array([0.0, 0.0, left]), True, drive, LIMITS, straight)
    assert straight.resistance == 0.0 and 0.02 < again.resistance <= 0.06
    assert FineMove(np.array([0.0, 0.0, -left]), True, drive, LIMITS, straight).resistance == 0.0


def test_a_chair_that_nothing_moves_is_not_pushed_for_long() -> None:
    """Against a threshold: every move ends within a second, however much resistance is reckoned with."""
    before = None
    for _ in range(8):
        before = FineMove(np.array([-0.02, 0.0, 0.0]), False, chair(AxisDrive()), LIMITS, before)
        done, asked = carry_out(before, AxisDrive(), resistance=1.0, seconds=1.2)
        assert done == 0.0 and max(asked) <= 0.08
