import dataclasses
import math

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step
from seater_eval.baselines.bay_speed import SlowInBay
from seater_eval.baselines.closed_loop import euler_step, limited, run_perfect
from seater_eval.baselines.do_mpc_baseline import DoMpc
from seater_eval.baselines.nmpc import Nmpc, available_solvers, for_perfect_chair
from seater_eval.baselines.paper_formulation import PaperFormulation
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs, PbvsGains
from seater_eval.baselines.polar import polar, within_limits
from seater_nmpc.parameters import ControlParameters

CHAIR, DOCK = Chair(), Dock()
LIMITS = CHAIR.limits
PERFECT = for_perfect_chair(ControlParameters())
FREE = dataclasses.replace(PERFECT, walls=False, horizon=20)
STARTS = [(-2.0, 0.0, 0.0), (-2.5, 0.8, -0.35), (-1.5, 2.0, 0.0)]


def arrived(millimetres: float, degrees: float):
    return lambda pose, _: math.hypot(*pose[:2]) < 1e-3 * millimetres and abs(pose[2]) < math.radians(degrees)


@pytest.mark.parametrize("start", [*STARTS, (1.5, 2.0, -0.5 * math.pi), (-1.5, 2.0, 0.5 * math.pi)])
@pytest.mark.parametrize("law", [ParkKuipers, Pbvs])
def test_feedback_laws_reach_the_dock_in_free_space(law, start) -> None:
    """They stop within 1 mm, where the line of sight loses its meaning; heading goes to zero with the distance."""
    run = run_perfect(law(LIMITS), LIMITS, start, 60.0)
    assert run.final_position_error < 1.0e-3
    assert math.degrees(run.final_heading_error) < 1.0


def test_do_mpc_reaches_the_dock_in_free_space() -> None:
    parameters = dataclasses.replace(FREE, horizon=15, control_period=0.1)
    run = run_perfect(DoMpc(CHAIR, None, parameters), LIMITS, (-1.2, 0.2, -0.1), 8.0, until=arrived(5.0, 0.5))
    assert run.final_position_error < 5e-3
    assert run.failures == 0


@pytest.mark.extensive  # it reaches the dock always
def test_do_mpc_has_the_same_problem_as_the_docking_controller() -> None:
    """Walls, bay speed and penalty included: the two drive the same way, but for the field of view, which is easy
    here."""
    parameters = dataclasses.replace(PERFECT, horizon=12, control_period=0.1)
    start, loops = (-1.1, 0.05, 0.02), []
    for controller in (DoMpc(CHAIR, DOCK, parameters), Nmpc(CHAIR, DOCK, parameters, "ipopt")):
        loops.append(run_perfect(controller, LIMITS, start, 1.5))
    np.testing.assert_allclose(loops[0].poses, loops[1].poses, atol=2e-4)


def test_the_docking_controller_reaches_the_dock_in_free_space() -> None:
    run = run_perfect(Nmpc(CHAIR, DOCK, FREE), LIMITS, STARTS[0], 12.0, until=arrived(1.0, 0.1))
    assert run.final_position_error < 1e-3


def test_the_papers_formulation_comes_within_centimetres() -> None:
    """Its known accuracy: it stalls. Iterations are cut because its kink can cost Ipopt thousands of them."""
    controller = PaperFormulation(CHAIR, None, max_iterations=60)
    run = run_perfect(controller, LIMITS, STARTS[0], 8.0, model=euler_step, accelerations=False)
    assert run.final_position_error < 0.05
    assert run.final_heading_error < math.radians(2.0)


def test_unknown_solver_is_named() -> None:
    with pytest.raises(ValueError, match="'simplex'"):
        Nmpc(CHAIR, DOCK, FREE, "simplex")
    assert "ipopt" in available_solvers()


def test_polar_coordinates() -> None:
    """From (-1, -1) facing along x: the dock is to the front left, seen under 45 degrees."""
    at = polar((-1.0, -1.0, 0.0))
    assert at.distance == pytest.approx(math.sqrt(2.0))
    assert at.target == pytest.approx(-0.25 * math.pi) and at.vehicle == pytest.approx(-0.25 * math.pi)
    behind = polar((1.0, 0.0, 0.0), backward=True)
    assert behind.target == pytest.approx(0.0, abs=1e-12) and behind.vehicle == pytest.approx(0.0, abs=1e-12)


def test_park_kuipers_curvature_against_the_formula() -> None:
    """On the line y = 0 ahead of the dock, turned by delta: theta = 0, kappa = -(k2 delta + (1 + k1) sin delta) / r."""
    delta, r = 0.2, 2.0
    v, omega = ParkKuipers(LIMITS).command((-r, 0.0, delta), (0.0, 0.0))
    assert omega / v == pytest.approx(-(2.0 * delta + 4.0 * math.sin(delta)) / r)


def test_unstable_gains_are_refused() -> None:
    with pytest.raises(ValueError, match="k_alpha > k_rho"):
        PbvsGains(k_rho=2.0)
    with pytest.raises(ValueError, match="turns its back"):
        PbvsGains(k_rho=0.9, k_alpha=1.0, k_beta=-0.5)


def test_limits_keep_the_curvature_or_the_rate() -> None:
    v, omega = within_limits(1.2, 0.4, LIMITS)
    assert (v, omega) == pytest.approx((0.6, 0.2))
    v, omega = within_limits(-0.2, 1.6, LIMITS)
    assert (v, omega) == pytest.approx((-0.1, 0.8))
    assert limited((0.6, 0.8), (0.0, 0.0), LIMITS, 0.1) == pytest.approx((0.05, 0.1))
    assert limited((9.0, 9.0), (0.0, 0.0), LIMITS, 0.1, accelerations=False) == (0.6, 0.8)


def test_euler_step_is_the_papers_and_differs_from_the_arc() -> None:
    pose = np.array([0.0, 0.0, 0.0])
    np.testing.assert_allclose(euler_step(pose, 0.5, 0.8, 0.1), [0.05, 0.0, 0.08])
    assert arc_step(pose, 0.5, 0.8, 0.1)[1] > 1e-3


def test_a_law_that_knows_no_bay_is_slowed_down_in_it() -> None:
    law = SlowInBay(ParkKuipers(LIMITS), CHAIR, DOCK)
    run = run_perfect(law, LIMITS, (-2.0, 0.0, 0.0), 20.0)
    inside = (
        run.poses[:-1, 0] > DOCK.bay.entrance_x - CHAIR.length_front
    )  # speeds[k + 1] is that of the step from poses[k]
    assert np.max(run.speeds[1:][inside, 0]) <= LIMITS.v_bay_max + 1e-9
    assert np.max(run.speeds[:, 0]) == pytest.approx(LIMITS.v_max)
    assert run.final_position_error < 1e-3
