"""One small move of a standing chair: how far it goes, in which direction, and what the next one learns from it."""

from types import SimpleNamespace

import numpy as np
import pytest

from seater_common.geometry import Chair
from seater_nmpc.drive.axis import AxisDrive, ChairDrive
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.correction import Correction
from seater_nmpc.sequence.rest.fine_move import FineMove
from seater_nmpc.sequence.rest.roll import Roll
from seater_nmpc.sequence.rest.small_moves import SmallMoves

LIMITS, PERIOD = Chair().limits, 0.05
LAG, STEPS = 0.2, 20
DRIVES = {
    "no deadband": AxisDrive(),
    "gain": AxisDrive(0.8),
    "jump": AxisDrive(1.0, 0.04),
    "offset": AxisDrive(1.0, 0.04, True),
}


def chair(axis: AxisDrive) -> ChairDrive:
    return ChairDrive(axis, axis, LAG, LAG)


def carry_out(move, axis: AxisDrive, resistance: float = 0.0, seconds: float = 5.0) -> tuple[float, list[float]]:
    """Way or turn of the chair, and the speeds that were asked for, until the move is over and the chair at rest.

    The motors follow with a lag; castors hold against what they give.
    """
    done = speed = command = 0.0
    step = (LIMITS.alpha_max if move.turning else LIMITS.a_max) * PERIOD  # as the controller limits it
    asked: list[float] = []
    for k in range(round(seconds / PERIOD)):
        speeds = move.speeds() if k == len(asked) else None
        if speeds is not None:
            assert speeds[0 if move.turning else 1] == 0.0  # straight or on the spot
            asked.append(speeds[1 if move.turning else 0])
        wanted = axis.command(asked[k]) if k < len(asked) else 0.0
        command = float(np.clip(wanted, command - step, command + step)) if k < len(asked) else 0.0
        for _ in range(STEPS):
            speed += (axis.effective(command) - speed) * PERIOD / STEPS / LAG
            done += np.sign(speed) * max(0.0, abs(speed) - resistance) * PERIOD / STEPS
    assert len(asked) < seconds / PERIOD, "the move does not end"
    return done, asked


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("turning", [False, True], ids=["straight", "turning"])
def test_a_chair_that_does_as_it_is_known_to_do_gets_there(name: str, turning: bool) -> None:
    """To within a fifth, as it may be held or not, and half of what the fastest cycle drives; where a deadband may be
    taken off every command or not, it comes short rather than too far."""
    short = 0.4 if DRIVES[name].offset else 0.2
    axis, largest = DRIVES[name], 0.12 if turning else 0.03
    for size in np.linspace(0.2 * largest, largest, 10):
        for error in (size, -size):
            move = FineMove(np.array([error, 0.002, error]), turning, chair(axis), LIMITS, PERIOD)
            done, asked = carry_out(move, axis)
            fastest = max(abs(speed) for speed in asked)
            half_a_cycle = 0.5 * fastest * PERIOD
            assert -short * size - half_a_cycle <= -np.sign(error) * done - size <= 0.2 * size + half_a_cycle
            assert all(speed * error < 0.0 for speed in asked)
            assert fastest <= max(0.35 if turning else 0.08, axis.smallest_speed) + 1e-9
            assert len(asked) * PERIOD <= 0.6 + 1e-9


def test_without_an_error_nothing_moves() -> None:
    assert FineMove(np.array([0.0, 0.004, 0.05]), False, chair(AxisDrive()), LIMITS, PERIOD).speeds() is None
    assert FineMove(np.array([0.01, 0.004, 0.0]), True, chair(AxisDrive()), LIMITS, PERIOD).speeds() is None


def in_series(truth: AxisDrive, resistance: float, error: float, turning: bool, roll: float = 0.0) -> list[float]:
    """Errors left after each of up to six moves, of a chair with this axis and castors that hold against it so much, of
    which nobody knows, and that rolls on so far each time; over when within 3 mm or 0.5 deg."""
    before, left, enough = None, [error], 0.009 if turning else 0.003
    while len(left) <= 6 and abs(left[-1]) > enough:
        before = FineMove(np.array([left[-1], 0.0, left[-1]]), turning, chair(AxisDrive()), LIMITS, PERIOD, before)
        if not before.is_worthwhile:
            break
        left.append(left[-1] + carry_out(before, truth, resistance)[0] + roll)
    return left


@pytest.mark.parametrize(("resistance", "moves"), [(0.0, 1), (0.03, 2), (0.06, 2), (0.1, 4)])
def test_resistance_against_turning_is_learned_from_how_far_the_last_move_got(resistance: float, moves: int) -> None:
    """Of 1.7 deg, less than 0.5 deg are left after so many moves, and none goes beyond that the other way."""
    left = in_series(AxisDrive(), resistance, -0.03, turning=True)
    assert len(left) - 1 <= moves and abs(left[-1]) <= 0.009


@pytest.mark.parametrize("offset", [False, True])
@pytest.mark.parametrize("error", [-0.004, -0.007, 0.012])
def test_a_deadband_that_was_never_met_is_learned(offset: bool, error: float) -> None:
    """Nothing below 0.03 m/s: at the dock in three moves."""
    left = in_series(AxisDrive(1.0, 0.03, offset), 0.0, error, turning=False)
    assert len(left) - 1 <= 3 and abs(left[-1]) <= 0.003


@pytest.mark.parametrize("roll", [0.012, -0.02])
def test_on_a_slope_the_roll_is_learned(roll: float) -> None:
    """Forward or backward after each push, by more than the error was: at the dock to 3 mm with the third move."""
    left = in_series(AxisDrive(), 0.0, -0.008, turning=False, roll=roll)
    assert len(left) - 1 <= 3 and abs(left[-1]) <= 0.003


def after(error: float, left: float, begin: float, turning: bool = True) -> float:
    """Resistance that a move from `begin` reckons with, after one in turning that led from `error` to `left`."""
    first = FineMove(np.array([error, 0.0, error]), True, chair(AxisDrive()), LIMITS, PERIOD)
    carry_out(first, AxisDrive())
    first = FineMove(np.array([left, 0.0, left]), True, chair(AxisDrive()), LIMITS, PERIOD, first)
    return FineMove(np.array([begin, 0.0, begin]), turning, chair(AxisDrive()), LIMITS, PERIOD, first).resistance


def fresh(turning: bool) -> float:
    """The same with nothing learned."""
    return FineMove(np.array([0.01, 0.0, 0.01]), turning, chair(AxisDrive()), LIMITS, PERIOD).resistance


def test_what_is_learned_holds_for_one_direction_of_one_axis() -> None:
    assert after(0.03, 0.025, 0.01) > 1.5 * fresh(True) > 1.5 * after(0.03, -0.005, 0.01)
    assert after(0.03, 0.025, -0.01) == pytest.approx(fresh(True))
    assert after(0.03, 0.025, 0.01, turning=False) == pytest.approx(fresh(False))


def test_what_was_learned_of_turning_outlives_a_straight_move_in_part() -> None:
    """On castors the two alternate: a turn on the spot, some millimetres ahead, the rest of the turn."""
    drive = chair(AxisDrive())
    turn = FineMove(np.array([-0.01, 0.0, 0.03]), True, drive, LIMITS, PERIOD)
    left = 0.03 + carry_out(turn, AxisDrive(), 0.1)[0]
    again = FineMove(np.array([-0.01, 0.0, left]), True, drive, LIMITS, PERIOD, turn).resistance
    turn = FineMove(np.array([-0.01, 0.0, 0.03]), True, drive, LIMITS, PERIOD)
    carry_out(turn, AxisDrive(), 0.1)
    straight = FineMove(np.array([-0.01, 0.0, left]), False, drive, LIMITS, PERIOD, turn)
    carry_out(straight, AxisDrive())
    later = FineMove(np.array([0.0, 0.0, left]), True, drive, LIMITS, PERIOD, straight).resistance
    assert fresh(True) < later < again


def test_a_chair_that_nothing_moves_is_not_pushed_for_long() -> None:
    """Against a wall: every move ends within 0.6 s, no matter what it has learned."""
    before = None
    for _ in range(8):
        before = FineMove(np.array([-0.02, 0.0, 0.0]), False, chair(AxisDrive()), LIMITS, PERIOD, before)
        done, asked = carry_out(before, AxisDrive(), resistance=1.0)
        assert done == 0.0 and max(asked, default=0.0) <= 0.08 and len(asked) * PERIOD <= 0.6 + 1e-9


@pytest.mark.parametrize(
    ("begin", "rolls"), [(0.03, 0.015), (0.03, 0.02), (0.023, 0.038), (-0.02, -0.012), (-0.012, -0.014)]
)
def test_a_chair_that_rolls_while_its_brakes_are_open_gets_there(begin: float, rolls: float) -> None:
    """On a slope, `rolls` after each push and as fast during it; the last stop has shown it. Towards the dock no push
    is faster for that."""
    roll = Roll(rolls / 1.3, 1.3)
    x, before, deadband = begin, None, AxisDrive(1.0, 0.02, True)
    for _ in range(3):
        before = FineMove(np.array([x, 0.0, 0.0]), False, chair(deadband), LIMITS, PERIOD, before, roll=roll, must=True)
        done, asked = carry_out(before, deadband, resistance=0.004)
        assert max(map(abs, asked)) <= (0.15 if begin > 0.0 else 0.08) + 1e-9
        x += done + roll.way(len(asked) * PERIOD)
        if abs(x) < 0.008:
            break
    assert abs(x) < 0.008


def test_with_the_chair_known_but_for_its_roll_one_push_is_enough() -> None:
    """What it rolls during the push is reckoned with: a third of the way here."""
    roll = Roll(0.02, 0.6)
    move = FineMove(np.array([0.012, 0.0, 0.0]), False, chair(AxisDrive()), LIMITS, PERIOD, roll=roll)
    done, asked = carry_out(move, AxisDrive())
    assert abs(0.012 + done + roll.way(len(asked) * PERIOD)) < 0.004


def test_a_chair_that_does_not_roll_though_a_stop_seemed_to_show_it_is_not_pushed_far_beyond() -> None:
    x, before = 0.02, None
    for _ in range(4):
        roll = Roll(0.02, 1.0) if before is None else Roll(0.005, 1.0)
        before = FineMove(np.array([x, 0.0, 0.0]), False, chair(AxisDrive()), LIMITS, PERIOD, before, roll=roll)
        x += carry_out(before, AxisDrive())[0]
        assert x > -0.03
        if abs(x) < 0.006:
            break
    assert abs(x) < 0.006


def test_a_push_ahead_is_tried_where_one_back_is_not() -> None:
    """What stands 4.4 mm off behind a deadband: ahead it costs no change of direction."""
    drive = ChairDrive(AxisDrive(1.0, 0.03, True), AxisDrive(), 0.28, 0.28)
    ahead, back = (FineMove(np.array([x, 0.0, 0.0]), False, drive, LIMITS, 0.08) for x in (-0.0044, 0.0044))
    assert ahead.is_worthwhile and not back.is_worthwhile


def test_a_chair_that_has_rolled_too_far_ahead_is_pushed_back_at_first_only() -> None:
    drive, error = ChairDrive(AxisDrive(1.0, 0.02, False), AxisDrive(), 0.25, 0.25), np.array([0.0059, 0.0, 0.0])
    first, later = (
        FineMove(error, False, drive, LIMITS, PERIOD, roll=Roll(0.012, 0.6), early=early) for early in (True, False)
    )
    assert first.is_worthwhile and not later.is_worthwhile


OFFSET = AxisDrive(1.0, 0.02, True)  # the chair
BELIEVED = chair(AxisDrive(1.0, 0.0173))  # of it
ROLL = Roll(0.026, 1.45)


def pushed(x: float, before: FineMove | None, *, early: bool = False) -> tuple[float, FineMove]:
    """Where it stands after the next push."""
    move = FineMove(np.array([x, 0.0, 0.0]), False, BELIEVED, LIMITS, PERIOD, before, roll=ROLL, must=True, early=early)
    done, asked = carry_out(move, OFFSET)
    assert move.is_worthwhile and all(speed < 0.0 for speed in asked)
    x += done + ROLL.way(PERIOD * len(asked))
    move.learn(np.array([x, 0.0, 0.0]))
    return x, move


def test_a_chair_that_rolls_farther_than_it_has_to_go_is_pushed_against_its_roll() -> None:
    """10 mm before the dock, it rolls 38: the alternative was another attempt."""
    before = pushed(0.028, None)[1]
    before.leave()
    x, _ = pushed(-0.01, before, early=True)
    assert abs(x) < 0.008


def test_after_a_turn_it_is_pushed_back_over_all_that_it_has_rolled() -> None:
    """Two rolls' way in one push, once others have shown how much less than asked for they do."""
    x, before = pushed(0.028, None)
    x, before = pushed(x, before)
    assert abs(pushed(0.07, before)[0]) < 0.008


def test_a_roll_of_five_centimetres_is_believed() -> None:
    """The rolls that were thought possible ended at 40 mm."""
    move = FineMove(np.array([0.02, 0.0, 0.0]), False, BELIEVED, LIMITS, PERIOD, roll=Roll(0.035, 1.45))
    assert move._response.roll == pytest.approx(-0.05, abs=0.003)


def test_what_pushes_have_shown_is_kept_in_part_for_another_attempt() -> None:
    """It was forgotten: the first push of each attempt was as short of the dock as the first of all."""
    moves, left = SmallMoves(LIMITS, SimpleNamespace(drive=BELIEVED), SequenceParameters()), []
    for _ in range(2):
        x = 0.028
        for _ in range(2):
            error = np.array([x, 0.0, 0.0])
            assert moves.choose(error, ROLL, PERIOD) is Correction.MOVE
            moves.begin(error)
            done, asked = carry_out(moves.move, OFFSET)
            x += done + ROLL.way(PERIOD * len(asked))
            left.append(x)
            if x < 0.006:
                break
        moves.leave(back_soon=False)
    assert left[0] > 0.01 > 0.006 > abs(left[-1]) and len(left) == 3, left
