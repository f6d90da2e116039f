"""The solvers against one another, and the real-time iteration's own promises."""

import math
from dataclasses import fields, replace

import casadi as ca
import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, clearance
from seater_common.se2 import arc_step
from seater_nmpc.control.command import Status
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.constraints.corners import best_angle
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.ocp.model import augmented_step, step_curvature
from seater_nmpc.ocp.problem import step_lengths
from seater_nmpc.parameters import ControlParameters, IpoptParameters, RtiParameters, Weights
from seater_nmpc.programme import WarmStart
from seater_nmpc.solve.interface import SolveStatus
from seater_nmpc.solve.ipopt import IpoptSolver
from seater_nmpc.solve.registry import SOLVERS, make_solver

CHAIR, DOCK = Chair(), Dock()
AREAS = dock_areas(DOCK)
# The solvers are judged on one programme, whatever weights the chair drives with.
PARAMETERS = ControlParameters(weights=Weights(y=10.0, heading=0.1))


@pytest.fixture(scope="module")
def problem():
    return make_problem(CHAIR, PARAMETERS, AREAS)


def test_the_choices_of_the_parameter_are_the_solvers() -> None:
    choices = {field.name: field.metadata.get("choices") for field in fields(ControlParameters)}
    assert sorted(choices["solver"]) == sorted(SOLVERS)


def build(problem, name: str, **rti):
    parameters = replace(PARAMETERS, solver=name, rti=RtiParameters(**rti))
    return make_solver(problem, parameters)


@pytest.fixture(scope="module")
def ipopt(problem):
    return build(problem, "ipopt")


def standing(problem, state):
    states = np.repeat(np.array(state, dtype=float)[None], PARAMETERS.horizon + 1, axis=0)
    states[:, 3:] = 0.0
    return WarmStart(problem.guess(states, AREAS))


@pytest.fixture(scope="module")
def instances(problem, ipopt):
    """Random states that see the dock: the solution nearby, the instance, its own solution (to a tighter tolerance)."""
    rng, found = np.random.default_rng(1), []
    tight = IpoptSolver(problem.functions, IpoptParameters(tolerance=1e-10, max_iterations=500))
    while len(found) < 10:
        state = rng.uniform([-3.0, -1.0, -0.6, 0.0, -0.3], [-0.8, 1.0, 0.6, 0.4, 0.3])
        if abs(math.atan2(-state[1], 0.9 - state[0]) - state[2]) > 0.5:
            continue
        near = ipopt.solve(problem.data(state, AREAS), standing(problem, state))
        data = problem.data(state + rng.normal(size=5) * [0.01, 0.01, 0.01, 0.01, 0.02], AREAS)
        exact = tight.solve(data, near.warm_start())
        assert near.status is exact.status is SolveStatus.SOLVED
        found.append((near, data, exact))
    return found


def test_rti_converges_to_ipopts_solution(problem, instances) -> None:
    solver = build(problem, "rti", iterations=20)
    for near, data, exact in instances:
        solution = solver.solve(data, near.warm_start())
        assert solution.status is SolveStatus.SOLVED and solution.iterations == 20
        assert solution.cost == pytest.approx(exact.cost, rel=2e-5, abs=1e-4)
        assert problem.plan(solution.x).states[1] == pytest.approx(problem.plan(exact.x).states[1], abs=1e-4)


def test_one_step_is_nearly_there_feasible_and_honest(problem, instances) -> None:
    solver = build(problem, "rti")
    limits = CHAIR.limits
    for near, data, exact in instances:
        solution = solver.solve(data, near.warm_start())
        plan = problem.plan(solution.x)
        assert solution.status is SolveStatus.SOLVED and solution.iterations == 1 and solution.violation < 1e-3
        assert plan.states[1, 3:] == pytest.approx(problem.plan(exact.x).states[1, 3:], abs=0.01)
        assert np.max(np.abs(plan.states[:, 4])) <= limits.omega_max + 1e-6
        rates = np.diff(plan.states[:, 3:], axis=0) / PARAMETERS.step
        assert np.all(np.abs(rates) <= np.array([limits.a_max, limits.alpha_max]) + 1e-3)
        nearest = min(clearance(CHAIR, DOCK.bay, pose) for pose in plan.states[1:, :3])
        assert nearest >= PARAMETERS.margin - plan.violation - 1e-6


def test_fatrop_agrees_with_ipopt(problem, instances) -> None:
    solver = build(problem, "fatrop")
    near, data, exact = instances[0]
    solution = solver.solve(data, near.warm_start())
    assert solution.status is SolveStatus.SOLVED and solution.violation < 1e-3
    assert solution.cost == pytest.approx(exact.cost, rel=1e-2)
    assert problem.plan(solution.x).states[1] == pytest.approx(problem.plan(exact.x).states[1], abs=5e-3)
    assert solution.lam_g.shape == exact.lam_g.shape and solution.lam_x.shape == exact.lam_x.shape


def test_default_ipopt_finds_the_same(problem, instances) -> None:
    near, data, exact = instances[1]
    solution = build(problem, "ipopt_default").solve(data, near.warm_start())
    assert solution.cost == pytest.approx(exact.cost, rel=1e-4)


def test_rti_reports_numbers_that_are_not_finite_and_recovers(problem, instances) -> None:
    solver = build(problem, "rti")
    near, data, _ = instances[0]
    bad = solver.solve(replace(data, p=np.full_like(data.p, math.nan)), near.warm_start())
    assert bad.status is SolveStatus.FAILED and np.all(np.isfinite(bad.x))
    broken = replace(near.warm_start(), x=np.full_like(near.x, math.nan))
    assert solver.solve(data, broken).status is SolveStatus.FAILED
    assert solver.solve(data, near.warm_start()).status is SolveStatus.SOLVED


def test_a_failed_quadratic_programme_leads_to_the_fallback(controller, monkeypatch) -> None:
    """Bounds that exclude each other: the controller follows its last plan, and drives on when they are right again."""
    controller.reset()
    pose, velocity = np.array([-2.5, 0.3, -0.1]), (0.0, 0.0)
    true_data, statuses = controller._replanner._problem.data, []
    for k in range(24):
        impossible = 10 <= k < 14
        data = (lambda *given: _impossible(true_data(*given))) if impossible else true_data
        monkeypatch.setattr(controller._replanner._problem, "data", data)
        command = controller.command(pose, velocity, [0.0, 0.0, 0.0], stamp=0.05 * k)
        velocity = (command.v, command.omega)
        pose = arc_step(pose, *velocity, 0.05)
        statuses.append(command.status)
        assert math.isfinite(command.v) and math.isfinite(command.omega)
    assert set(statuses[:10]) == {Status.SOLVED} and set(statuses[10:14]) == {Status.FALLBACK_SHIFTED}
    assert set(statuses[14:]) == {Status.SOLVED} and velocity[0] > 0.3


def _impossible(data):
    lower, upper = data.lbg.copy(), data.ubg.copy()
    lower[:5] = upper[:5] = 1e3  # the first step's dynamics: nowhere near the bounds of the inputs
    return replace(data, lbg=lower, ubg=upper)


@pytest.mark.parametrize("integrator", ["arc", "euler"])
def test_curvature_of_a_step_is_the_convex_part(integrator) -> None:
    """Against the exact second derivative where that is convex or concave, and positive semidefinite everywhere."""
    z, u, force = ca.SX.sym("z", 5), ca.SX.sym("u", 2), ca.SX.sym("force", 2)
    zu = ca.vertcat(z, u)
    exact = ca.hessian(ca.dot(force, augmented_step(z, u, 0.1, integrator)[:2]), zu)[0]
    both = ca.Function("both", [z, u, force], [exact, step_curvature(z, u, force, 0.1, integrator)])
    rng = np.random.default_rng(0)
    for _ in range(50):
        H, convex = (m.full() for m in both(rng.normal(size=5), rng.normal(size=2), rng.normal(size=2)))
        assert np.min(np.linalg.eigvalsh(convex)) > -1e-9
        values, vectors = np.linalg.eigh(H)
        projected = vectors @ np.diag(np.maximum(values, 0.0)) @ vectors.T
        assert convex[:3, :3] == pytest.approx(projected[:3, :3], abs=0.01)


def test_best_angle_is_the_best_of_a_fine_scan() -> None:
    corners, heading, first, last = ca.SX.sym("c", 4, 2), ca.SX.sym("h"), ca.SX.sym("a"), ca.SX.sym("b")
    best = ca.Function("best", [corners, heading, first, last], [best_angle(corners, heading, first, last)])
    rng = np.random.default_rng(0)
    for _ in range(100):
        pose = rng.uniform([-2.0, -2.0, -3.0], [2.0, 2.0, 3.0])
        V, begin = CHAIR.corners_at(pose), rng.uniform(-4.0, 4.0)
        end = begin + rng.uniform(0.1, 3.0)

        def margin(angles, V=V):
            return np.min(V @ np.array([np.cos(angles), np.sin(angles)]), axis=0)

        angle = float(best(V, pose[2], begin, end))
        assert begin - 1e-9 <= angle <= end + 1e-9
        assert margin(angle) >= np.max(margin(np.linspace(begin, end, 500))) - 1e-6


def test_fine_steps_come_first() -> None:
    steps = step_lengths(replace(PARAMETERS, horizon=6, fine_steps=2, step=0.2))
    assert steps == pytest.approx([0.05, 0.05, 0.2, 0.2, 0.2, 0.2])
    plan = make_problem(CHAIR, replace(PARAMETERS, fine_steps=10), AREAS)
    assert plan.plan(standing_x(plan)).times[-1] == pytest.approx(10 * 0.05 + 20 * 0.1)


def standing_x(problem):
    return problem.guess(np.zeros((PARAMETERS.horizon + 1, 5)), AREAS)
