"""Absurd but finite inputs: commands stay within the limits, whatever the solver."""

import math
from dataclasses import replace

import numpy as np
import pytest
from conftest import AT_ONCE, observation

from seater_common.geometry import Chair, Dock
from seater_nmpc.control.command import Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.solve.registry import SOLVERS

CHAIR, DOCK, PERIOD = Chair(), Dock(), 0.05
FALLBACK = {Status.FALLBACK_SHIFTED, Status.FALLBACK_BRAKE}
AT_WORK, HARMED, AGAIN = 5, 14, 2  # cycles


@pytest.fixture(scope="module", params=SOLVERS)
def of_each_solver(request) -> DockingController:
    parameters = replace(ControlParameters(prediction=AT_ONCE), solver=request.param, horizon=10, step=0.2)
    return DockingController(CHAIR, DOCK, parameters, deterministic=True)


@pytest.mark.parametrize(
    ("pose", "velocity"),
    [
        ([1e300, 0.0, 0.0], (0.0, 0.0)),
        ([1.7e308, -1.7e308, 1e300], (0.0, 0.0)),
        ([1e6, 1e6, 1e6], (0.0, 0.0)),
        ([-2.0, 0.0, 0.0], (1e6, -1e6)),
        ([-2.0, 0.0, 0.0], (-2.0, 3.0)),
        ([-2.0, 0.0, 0.0], (1e308, 1e308)),
    ],
)
def test_absurd_but_finite_inputs_stay_within_the_limits(of_each_solver, pose, velocity) -> None:
    controller, limits = of_each_solver, CHAIR.limits
    controller.reset()
    for k in range(3):
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0], stamp=k * PERIOD)
        assert math.isfinite(command.v) and math.isfinite(command.omega)
        assert -limits.v_reverse_max <= command.v <= limits.v_max and abs(command.omega) <= limits.omega_max
    sane = [controller.command([-2.0, 0.0, 0.0], (0.0, 0.0), [0.0, 0.0, 0.0], stamp=(3 + k) * PERIOD) for k in range(2)]
    assert sane[-1].status not in FALLBACK


@pytest.mark.parametrize("value", [1e11, 1e155, -1e300])
def test_odometry_of_which_sums_would_overflow_is_refused(value: float) -> None:
    observer = DockObserver(CHAIR.camera)
    assert observer.add_odometry(Odometry(1.0, np.zeros(3), 0.0, 0.0))
    for change in ({"pose": np.array([value, 0.0, 0.0])}, {"v": value}, {"omega": value}, {"stamp": abs(value)}):
        assert not observer.add_odometry(replace(Odometry(1.1, np.zeros(3), 0.0, 0.0), **change))
    assert observer.add_odometry(Odometry(1.1, np.zeros(3), 0.0, 0.0))


@pytest.mark.parametrize("where", [(0, 3), (2, 3), (0, 0)])
def test_an_image_of_a_dock_absurdly_far_away_is_invalid(where: tuple[int, int]) -> None:
    """Its distance overflowed, passed the gate as NaN, and the estimate was not finite from then on."""
    observer = DockObserver(CHAIR.camera)
    observer.add_odometry(Odometry(1.0, np.zeros(3), 0.0, 0.0))
    seen = observation(CHAIR, np.array([2.0, 0.0, 0.0]))
    seen.T_optical_dock[where] = 1e300
    assert observer.add_detections(1.0, [seen]).outcome is Outcome.INVALID
