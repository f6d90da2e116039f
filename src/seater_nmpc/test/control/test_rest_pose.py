"""Where a chair comes to rest that is asked to stand now."""

import numpy as np
import pytest
from chairs import SlowChair
from driving import CHAIR, DOCK

from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import ControlParameters, Prediction

DELAY, LAG = 0.2, 0.3


@pytest.fixture(scope="module")
def controller() -> DockingController:
    prediction = Prediction(command_delay=DELAY, motor_lag=LAG, adapt=False)
    return DockingController(CHAIR, DOCK, ControlParameters(prediction=prediction, walls=False), deterministic=True)


@pytest.mark.parametrize("cycles", [0, 1, 3, 8, 20, 40])
def test_it_is_where_the_chair_comes_to_rest(controller, cycles: int) -> None:
    """At any time of a drive: with commands on their way, speeding up and at speed, in a curve."""
    controller.reset()
    controller.history.clear()
    chair = SlowChair([-2.5, 0.5, 0.2], DELAY, LAG)
    for _ in range(cycles):
        command = controller.command(chair.pose, (chair.v, chair.omega), [0.0, 0.0, 0.0], stamp=chair.now)
        chair.drive((command.v, command.omega), 0.05)
    now, begin = chair.now, chair.pose.copy()
    expected = controller.rest_pose(now, begin, (chair.v, chair.omega))
    chair.drive((0.0, 0.0), 4.0)
    assert expected == pytest.approx(chair.pose, abs=2e-4)
    moved = np.hypot(*(chair.pose - begin)[:2])
    assert (moved == 0.0 or cycles > 0) and (moved > 0.03 or cycles < 20)


def test_it_asks_for_nothing(controller) -> None:
    controller.reset()
    controller.history.clear()
    first = controller.rest_pose(1.0, [0.0, 0.0, 0.0], (0.3, 0.1))
    assert np.array_equal(controller.rest_pose(1.0, [0.0, 0.0, 0.0], (0.3, 0.1)), first)
    assert controller.history.since(0) == []
    assert first[0] > 0.3 * DELAY and first[1] > 0.0
