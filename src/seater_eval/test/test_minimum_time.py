import math

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, clearance
from seater_common.se2 import arc_step
from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.minimum_time import MinimumTime, profile_time, straight_line_bound
from seater_eval.baselines.minimum_time_programme import arrival_speeds
from seater_eval.baselines.pbvs import Pbvs

CHAIR, DOCK = Chair(), Dock()
LIMITS = CHAIR.limits


@pytest.fixture(scope="module")
def free() -> MinimumTime:
    return MinimumTime(CHAIR, None)


@pytest.fixture(scope="module")
def bay() -> MinimumTime:
    return MinimumTime(CHAIR, DOCK, DOCK.tolerance)


@pytest.mark.parametrize(
    ("x", "closed_form"),
    [
        (-2.0, 2.0 / 0.6 + 0.6 / 0.5),  # trapezoid
        (-0.3, 2.0 * math.sqrt(0.3 / 0.5)),  # triangle: the limit of speed is not reached
        (1.0, 1.0 / 0.3 + 0.3 / 0.5),  # backward
    ],
)
def test_straight_line_against_the_closed_form(free: MinimumTime, x: float, closed_form: float) -> None:
    solution = free.solve((x, 0.0, 0.0))
    assert solution is not None
    assert solution.time == pytest.approx(closed_form, rel=2e-3)  # on 40 steps; never better than the truth:
    assert solution.time >= closed_form - 1e-5
    assert profile_time(x, 0.6 if x < 0.0 else 0.3, 0.5) == pytest.approx(closed_form)


@pytest.mark.parametrize("turn", [0.3, 2.0])
def test_turn_on_the_spot_against_the_closed_form(free: MinimumTime, turn: float) -> None:
    solution = free.solve((0.0, 0.0, turn))
    assert solution is not None
    assert solution.time == pytest.approx(profile_time(turn, 0.8, 1.0), rel=2e-3)


def test_the_shorter_way_round_is_taken(free: MinimumTime) -> None:
    """From +170 degrees over 180 it is 190; the answer must be that of 170."""
    solution = free.solve((0.0, 0.0, math.radians(170.0)), max_guesses=3)
    assert solution is not None
    assert solution.time < profile_time(math.radians(190.0), 0.8, 1.0)


def test_the_motion_is_driveable_and_keeps_limits_and_walls(bay: MinimumTime) -> None:
    solution = bay.solve((-2.5, 0.8, -0.35), max_guesses=3)
    assert solution is not None
    pose, v, omega = np.array([-2.5, 0.8, -0.35]), 0.0, 0.0
    for k, (a, alpha) in enumerate(solution.accelerations):
        h, fine = solution.times[k + 1] - solution.times[k], 25
        for _ in range(fine):
            pose = arc_step(pose, v + 0.5 * a * h / fine, omega + 0.5 * alpha * h / fine, h / fine)
            v, omega = v + a * h / fine, omega + alpha * h / fine
            assert clearance(CHAIR, DOCK.bay, pose) > -0.002  # walls are kept clear of at the nodes
            if np.max(CHAIR.corners_at(pose)[:, 0]) > DOCK.bay.entrance_x + 0.002:
                assert abs(v) <= LIMITS.v_bay_max + 1e-5
    np.testing.assert_allclose(pose, solution.states[-1, :3], atol=1e-5)
    assert math.hypot(pose[0], pose[1]) <= DOCK.tolerance.position + 1e-5
    assert np.max(np.abs(solution.accelerations[:, 0])) <= LIMITS.a_max + 1e-6
    assert np.max(np.abs(solution.states[:, 4])) <= LIMITS.omega_max + 1e-6


def test_a_finer_mesh_agrees(bay: MinimumTime) -> None:
    fine = MinimumTime(CHAIR, DOCK, DOCK.tolerance, (80, 40)).solve((-3.0, 0.5, 0.2), max_guesses=3)
    coarse = bay.solve((-3.0, 0.5, 0.2), max_guesses=3)
    assert fine is not None and coarse is not None
    assert coarse.time == pytest.approx(fine.time, rel=5e-3)


@pytest.mark.parametrize("start", [(-2.5, 0.3, -0.1), (-3.5, -0.5, 0.2)])
def test_no_feedback_law_is_faster(start) -> None:
    solution = MinimumTime(CHAIR, None, DOCK.tolerance).solve(start, max_guesses=3)
    run = run_perfect(Pbvs(LIMITS), LIMITS, start, 40.0)
    time = run.docking_time(DOCK.tolerance)
    assert solution is not None and time is not None
    assert straight_line_bound(LIMITS, start, DOCK.tolerance) <= solution.time <= time


def test_arrival_speeds_are_those_of_braking_across_the_tolerance() -> None:
    v, omega = arrival_speeds(LIMITS, DOCK.tolerance)
    assert v**2 / (2.0 * LIMITS.a_max) == pytest.approx(2.02 * DOCK.tolerance.position)
    assert omega**2 / (2.0 * LIMITS.alpha_max) == pytest.approx(2.0 * DOCK.tolerance.heading)


def test_the_certain_bound_of_a_straight_drive() -> None:
    """To standing it would be the trapezoid; arriving with speed saves some."""
    tolerance = DOCK.tolerance
    bound = straight_line_bound(LIMITS, (-2.0, 0.0, 0.0), tolerance)
    v, _ = arrival_speeds(LIMITS, tolerance)
    whole = (0.6**2 - 0.5 * v**2) / 0.5
    assert bound == pytest.approx((1.99 - whole) / 0.6 + (2.0 * 0.6 - v) / 0.5)
