"""Where the first solve of a goal begins, and what that is good for."""

import numpy as np
import pytest
from chairs import SlowChair
from conftest import seldom
from driving import CHAIR, DOCK

from seater_nmpc.control.cold_start import heading_for_target, standing
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters

LENGTHS = np.full(30, 0.1)
VIEW = 0.78  # [rad] half of what the camera sees
BEFORE_THE_BAY = np.array([-0.9, 0.0, 0.0])  # the target


FAR = [(-3.72, 1.45, 0.23), seldom((-3.26, 1.49, 0.165)), seldom((-3.26, 1.16, 0.2)), seldom((-3.7, -1.45, -0.23))]


@pytest.mark.parametrize("start", FAR)
def test_a_far_chair_turned_aside_drives_forward_at_once(start) -> None:
    """From standing alone the optimisation found the minimum beside it: to back off, until no marker was in view."""
    controller = DockingController(CHAIR, DOCK, ControlParameters(view_half_angle=VIEW), deterministic=True)
    chair = SlowChair(start, 0.15, 0.2)
    for _ in range(30):
        command = controller.command(chair.pose, (chair.v, chair.omega), [0.0, 0.0, 0.0], BEFORE_THE_BAY, chair.now)
        assert command.v >= -0.02
        chair.drive((command.v, command.omega), 0.05, controller)
    assert chair.pose[0] > start[0] + 0.2 and chair.v > 0.3


@pytest.mark.parametrize("start", [(-4.0, 1.5, 0.5), (-1.0, -0.5, 0.2), (-0.6, 0.0, 0.0), (-3.0, 0.2, -1.2)])
def test_the_way_to_the_target_is_one_that_the_chair_can_drive(start) -> None:
    states = heading_for_target(np.array([*start, 0.0, 0.0]), LENGTHS, CHAIR.limits)
    assert states is not None and states.shape == (31, 5) and np.all(np.isfinite(states))
    assert tuple(states[0, :3]) == start
    limits = CHAIR.limits
    assert np.all((states[:, 3] >= 0.0) & (states[:, 3] <= limits.v_max)) and np.max(states[:, 0]) < 0.05
    assert np.max(np.abs(states[:, 4])) <= limits.omega_max
    assert np.max(np.abs(np.diff(states[:, 3]))) <= limits.a_max * 0.1 + 1e-9
    assert np.hypot(*states[-1, :2]) < np.hypot(*start[:2])


@pytest.mark.parametrize("start", [(-0.3, 0.1, 0.0), (0.5, 0.0, 0.0), (-2.0, 0.0, 3.0), (-2.0, 1.0, 1.3)])
def test_near_the_target_and_turned_away_from_it_standing_is_the_guess(start) -> None:
    state = np.array([*start, 0.2, 0.1])
    assert heading_for_target(state, LENGTHS, CHAIR.limits) is None
    states = standing(state, 30)
    assert states.shape == (31, 5) and np.all(states[:, 3:] == 0.0) and np.all(states[:, :3] == state[:3])
