"""What is done with a chair that stands near the dock."""

import numpy as np
import pytest

from seater_common.se2 import compose, inverse
from seater_nmpc.observe.measurement import Measurement
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.observe.odometry.travel import NO_TRAVEL
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.correction import Correction, judge, standing_dock, surely
from seater_nmpc.sequence.rest.roll import Roll
from seater_nmpc.sequence.rest.way_on import has_way_on, next_overshoot

P = SequenceParameters(
    hold_position=0.003, hold_heading=0.006, release_position=0.008, release_heading=0.014, max_moves=3
)


@pytest.mark.parametrize(
    ("error", "moves", "verdict"),
    [
        ((-0.002, 0.006, 0.005), 0, Correction.STAY),
        ((-0.002, 0.006, 0.007), 0, Correction.TURN),
        ((-0.02, 0.0, -0.1), 0, Correction.TURN),  # heading first: it moves what is ahead
        ((-0.02, 0.0, -0.1), 1, Correction.MOVE),  # after a turn the castors stand aside: driving on turns it, too
        ((-0.002, 0.0, -0.1), 1, Correction.TURN),
        ((-0.004, 0.0, 0.0), 0, Correction.MOVE),
        ((0.004, 0.0, 0.0), 0, Correction.STAY),  # a little too deep: not worth driving back
        ((0.005, 0.0, 0.0), 0, Correction.MOVE),
        ((0.009, 0.0, 0.0), 0, Correction.MOVE),
        ((0.006, 0.006, 0.0), 0, Correction.MOVE),  # rather than another attempt
        ((0.0, -0.009, 0.0), 0, Correction.AGAIN),  # no move on the spot mends that
        ((0.0, 0.0, 0.13), 0, Correction.AGAIN),
        ((-0.007, 0.0, 0.013), 3, Correction.STAY),  # no move left, but good enough
        ((-0.007, 0.0, 0.015), 3, Correction.AGAIN),
        ((-0.006, 0.006, 0.0), 3, Correction.AGAIN),
        ((-0.03, 0.0, 0.0), 2, Correction.MOVE),
        ((-0.03, 0.0, 0.0), 3, Correction.AGAIN),
    ],
)
def test_verdicts(error, moves: int, verdict: Correction) -> None:
    assert judge(np.array(error), moves, P) is verdict


def test_the_dock_is_the_mean_of_images_as_seen_from_the_standing_chair() -> None:
    """Whatever odometry drifts meanwhile: in odom these images are 30 cm apart."""
    T_base_dock, rng = np.array([0.9, -0.1, 0.2]), np.random.default_rng(3)
    fresh = []
    for k in range(100):
        T_odom_base = np.array([1.0 + 0.003 * k, 2.0, 0.5 + 0.01 * k])
        seen = compose(T_odom_base, T_base_dock + 0.002 * rng.normal(size=3))
        fresh.append((Instant(0.1 * k, T_odom_base, 0.0, 0.0, NO_TRAVEL), Measurement(seen, 4e-6 * np.eye(3))))
    assert standing_dock(fresh) == pytest.approx(T_base_dock, abs=8e-4)
    one = fresh[0]
    assert standing_dock([one]) == pytest.approx(compose(inverse(one[0].pose), one[1].pose))


def test_what_is_beyond_doubt_is_less_than_the_error() -> None:
    """By three standard deviations, and by a millimetre at least."""
    error = np.array([-0.006, 0.0005, 0.012])
    left = surely(error, np.diag([0.001, 0.0001, 0.0005]) ** 2)
    assert left == pytest.approx([-0.003, 0.0, 0.01])


@pytest.mark.parametrize(("bias", "moves"), [(0.0065, 1), (0.002, 0)])
def test_an_offset_that_only_verification_shows_is_mended(make_world, bias: float, moves: int) -> None:
    """The images before it show the chair too far ahead: 6.5 mm are worth a small move, 2 mm are not."""

    def shows(world, found):
        if world.phases[-1:] != ["VERIFY"]:
            for each in found:
                each.T_optical_dock[2, 3] -= bias
        return found

    world = make_world((-0.3, 0.0, 0.0), shows=shows)
    world.tick()
    world.sequence.start_dock(world.now)
    world.run(60.0, until=lambda step: step.phase.name == "VERIFY")
    before = world.phases.count("CORRECTING")
    world.shows = lambda world, found: found
    step = world.run(60.0)
    assert step.result is not None and step.result.success
    assert world.phases.count("CORRECTING") - before == moves, world.truth
    assert abs(world.truth[0]) < 0.004


def test_a_chair_that_is_only_short_of_the_dock_and_has_way_enough_drives_on() -> None:
    level, rolls, turns, rolls_on = Roll(), Roll(-0.02, 1.0), Roll(-0.02, 1.0, 0.01), Roll(0.02, 1.0)
    for error, overshoot, roll, drives in (
        ((-0.02, 0.0, 0.0), 0.0, level, True),
        ((-0.008, 0.0, 0.0), 0.0, level, False),  # no way to be steered on
        ((-0.008, 0.0, 0.0), -0.01, level, True),  # castors pushed it back
        ((-0.003, 0.0, 0.0), -0.02, rolls, False),  # stays
        ((-0.02, 0.02, 0.0), -0.02, rolls, False),
        ((-0.02, 0.0, 0.03), -0.02, rolls, False),
        ((-0.02, 0.0, 0.0), -0.02, turns, False),
        ((0.02, 0.0, 0.0), 0.02, level, False),
        ((-0.01, 0.0, 0.0), 0.02, rolls_on, False),  # it would have to stop before it has begun
        ((-0.03, 0.0, 0.0), 0.02, rolls_on, True),
    ):
        assert has_way_on(np.array(error), overshoot, roll, P) is drives, (error, overshoot)
    assert next_overshoot(-0.01, 0.0, level) == -0.01 and next_overshoot(-0.01, 0.0, rolls) == pytest.approx(-0.015)
    assert next_overshoot(None, -0.01, level) == -0.01 and next_overshoot(None, 0.0, rolls) == pytest.approx(-0.02)
