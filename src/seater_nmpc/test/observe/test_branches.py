"""Two places of the dock that the images of a chair that stands leave open, told apart once it moves."""

import numpy as np
import pytest
from two_poses import Drive

from seater_common.geometry import Dock
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.jump import sudden


@pytest.mark.parametrize(("slip", "drift"), [(0.0, 0.0), (0.12, 0.0), (0.0, 0.2)])
def test_the_wrong_one_of_two_is_left_within_a_few_decimetres(slip: float, drift: float) -> None:
    """However both drift in odom."""
    drive = Drive()
    drive.on(1.0, 0.0, 0.35)
    assert drive.off() > 0.2 and Outcome.ACQUIRED in drive.outcomes
    drive.observer.bound_reacquisition(True, Dock().front)
    before = len(drive.outcomes)
    drive.on(2.0, 0.3, 0.45, slip=slip, drift=drift)
    assert drive.off() < 0.05
    assert drive.outcomes[before:].count(Outcome.ACQUIRED) == 1
    jump = drive.observer.images.jump
    assert jump is None or sudden(jump, PlausibilityParameters()) is None
    assert drive.observer.elsewhere is None


@pytest.mark.parametrize("seed", [1, 2])
def test_nearly_head_on_the_wrong_one_moves_past_where_it_was(seed: int) -> None:
    """The right one is nearer then to where the wrong one was: the other filters were shown the wrong one from there
    on, and the chair had to stand until eight images agreed."""
    drive = Drive(seed)
    drive.pose, drive.each = np.array([-1.15, 0.3, 0.3]), 2
    drive.on(2.0, 0.0, 0.35)
    assert 0.08 < drive.off() < 0.12
    drive.observer.bound_reacquisition(True, Dock().front)
    before = len(drive.outcomes)
    drive.on(0.6, 0.25, 0.45, omega=0.35)
    assert Outcome.ACQUIRED in drive.outcomes[before:] and drive.off() < 0.03


def test_the_right_one_stays_though_images_favour_the_other() -> None:
    drive = Drive()
    drive.on(1.0, 0.0, 0.65)
    drive.on(3.0, 0.3, 0.4)
    assert drive.off() < 0.05 and drive.outcomes.count(Outcome.ACQUIRED) == 1


def test_images_of_a_chair_that_stands_err_alike_and_change_nothing() -> None:
    drive = Drive()
    drive.on(1.0, 0.0, 0.65)
    drive.on(5.0, 0.0, 0.1)
    assert drive.off() < 0.05


def test_nearby_the_dock_changes_no_more() -> None:
    drive = Drive()
    drive.pose = np.array([-0.25, -0.1, 0.0])
    drive.on(1.0, 0.0, 0.35)
    drive.observer.bound_reacquisition(True, Dock().front)
    before = len(drive.outcomes)
    drive.on(2.0, 0.1, 0.35)
    assert Outcome.ACQUIRED not in drive.outcomes[before:]
