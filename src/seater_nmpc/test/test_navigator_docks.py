"""The navigator and the controller together, in closed loop."""

import math

import numpy as np
import pytest
from conftest import seldom
from driving import distance_to

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step
from seater_nmpc.parameters import ControlParameters, PlannerParameters
from seater_nmpc.plan.navigator import Navigator

CHAIR, DOCK, PARAMETERS, CONTROL = Chair(), Dock(), PlannerParameters(), ControlParameters()
BESIDE_THE_BAY = (-1.2, 0.8, -0.2)
BOX = np.array([[-2.4, -0.5], [-1.9, -0.5], [-1.9, 0.5], [-2.4, 0.5]])
BEHIND_THE_BOX = (-4.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("start", "middle", "half"),
    [
        ((-3.2, 0.6, -0.175), (-2.17, 0.03), 0.15),
        seldom((-3.2, 0.6, -0.175), (-2.27, 0.06), 0.15),
        seldom((-3.8, 1.2, -0.5), (-2.8, 0.6), 0.25),
    ],
)
def test_a_box_near_the_start_is_passed(controller, start, middle, half) -> None:
    """Where a far target would lie behind the box's corner, and the controller stop in front of it."""
    box = np.array(middle) + half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    navigator = Navigator(CHAIR, DOCK, CONTROL)
    controller.reset()
    controller.set_obstacles([box])
    navigator.see(controller.obstacles)
    pose, velocity, nearest = np.array(start), (0.0, 0.0), math.inf
    for _ in range(300):
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0], navigator.target(pose))
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, CONTROL.control_period)
        nearest = min(nearest, distance_to(pose, [box, *DOCK.bay.outlines()]))
        if abs(pose[1]) < 0.05 and abs(pose[2]) < 0.1 and navigator.straight_way_clear(pose):
            break
    controller.set_obstacles([])
    assert abs(pose[1]) < 0.05 and pose[0] > middle[0]
    assert nearest >= CONTROL.margin - 0.01
