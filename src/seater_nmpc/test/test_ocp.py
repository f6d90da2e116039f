from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, clearance, polygon_distance
from seater_common.se2 import compose, relative
from seater_nmpc.ocp.area_constraints import AreaConstraints
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.constraints.corners import separating_angle
from seater_nmpc.ocp.constraints.interface import Slack
from seater_nmpc.ocp.constraints.view import UNKNOWN_CAMERA
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.parameters import ControlParameters, IpoptParameters, Weights
from seater_nmpc.programme import StageProgramme, WarmStart
from seater_nmpc.solve.interface import SolveStatus
from seater_nmpc.solve.ipopt import IpoptSolver
from seater_nmpc.solve.registry import make_solver

CHAIR, DOCK = Chair(), Dock()
AREAS = dock_areas(DOCK)
PARAMETERS = ControlParameters()


@pytest.fixture(scope="module")
def problem() -> DockingProblem:
    return DockingProblem(CHAIR, PARAMETERS, AREAS)


@pytest.fixture(scope="module")
def solver(problem: DockingProblem) -> IpoptSolver:
    return IpoptSolver(problem.functions, IpoptParameters())


def solve(problem, solver, state, areas=AREAS):
    states = np.repeat(np.array(state, dtype=float)[None], PARAMETERS.horizon + 1, axis=0)
    states[:, 3:] = 0.0
    solution = solver.solve(problem.data(np.array(state, dtype=float), areas), WarmStart(problem.guess(states, areas)))
    return solution, problem.plan(solution.x)


def test_derivatives_agree_with_differences(problem: DockingProblem) -> None:
    """Smooth everywhere the solver looks: cost and constraints against central differences at random points."""
    f = problem.functions
    both = ca.vertcat(f["f"], f["g"])
    value = ca.Function("value", [f["x"], f["p"]], [both])
    slope = ca.Function("slope", [f["x"], f["p"]], [ca.jacobian(both, f["x"])])
    rng, h = np.random.default_rng(0), 1e-6
    p = problem.data(np.zeros(5), AREAS).p
    for _ in range(5):
        x, direction = rng.normal(size=f["x"].numel()), rng.normal(size=f["x"].numel())
        numeric = (value(x + h * direction, p).full() - value(x - h * direction, p).full()) / (2 * h)
        exact = slope(x, p).full() @ direction[:, None]
        assert exact == pytest.approx(numeric, rel=1e-5, abs=1e-5)


def test_plan_keeps_limits_and_dynamics(problem, solver) -> None:
    start = [-2.0, 0.8, -0.3, 0.2, 0.1]
    solution, plan = solve(problem, solver, start)
    assert solution.status is SolveStatus.SOLVED and solution.violation < 1e-5
    limits, rates = CHAIR.limits, np.diff(plan.states[:, 3:], axis=0) / PARAMETERS.step
    assert plan.states[0] == pytest.approx(start)
    assert (
        np.max(plan.states[:, 3]) <= limits.v_max + 1e-6 and np.min(plan.states[:, 3]) >= -limits.v_reverse_max - 1e-6
    )
    assert np.max(np.abs(plan.states[:, 4])) <= limits.omega_max + 1e-6
    assert np.max(np.abs(rates[:, 0])) <= limits.a_max + 1e-5 and np.max(np.abs(rates[:, 1])) <= limits.alpha_max + 1e-5


def test_mirrored_start_gives_mirrored_plan(problem, solver) -> None:
    _, left = solve(problem, solver, [-2.0, 0.8, -0.3, 0.2, 0.1])
    _, right = solve(problem, solver, [-2.0, -0.8, 0.3, 0.2, -0.1])
    assert right.states == pytest.approx(left.states * [1, -1, -1, 1, -1], abs=1e-4)


def test_terminal_penalty_is_exact(problem, solver) -> None:
    """Near the target the plan ends on it, not near it; without the penalty it does not."""
    _, plan = solve(problem, solver, [-0.1, 0.0, 0.01, 0.0, 0.0])
    assert np.max(np.abs(plan.states[-1, :3])) < 2e-5
    weak = replace(PARAMETERS, weights=replace(Weights(), terminal=0.0))
    blunt = DockingProblem(CHAIR, weak, AREAS)
    _, plan = solve(blunt, IpoptSolver(blunt.functions, IpoptParameters()), [-0.1, 0.0, 0.01, 0.0, 0.0])
    assert np.max(np.abs(plan.states[-1, :3])) > 1e-3


def test_areas_keep_the_whole_footprint_out(problem, solver) -> None:
    """Heading for the wall's end: every pose of the plan keeps the margin, though the straight way does not."""
    start = np.array([-1.3, 0.35, 0.0, 0.3, 0.0])
    straight = min(clearance(CHAIR, DOCK.bay, [x, 0.35, 0.0]) for x in np.linspace(-1.3, 0.0, 20))
    assert straight < 0.0
    solution, plan = solve(problem, solver, start)
    assert solution.status is SolveStatus.SOLVED and plan.violation < 1e-4
    assert min(clearance(CHAIR, DOCK.bay, pose) for pose in plan.states[:, :3]) >= PARAMETERS.margin - 1e-4


def test_an_infeasible_start_is_solved_and_reported(problem, solver) -> None:
    """The front 3 cm inside the margin of the back wall: solvable, and the violation is the true one."""
    solution, plan = solve(problem, solver, [0.13, 0.0, 0.0, 0.0, 0.0])
    assert solution.status is SolveStatus.SOLVED
    assert plan.violation == pytest.approx(0.03, abs=0.003)
    assert plan.states[-1, 0] < 0.1


@pytest.mark.parametrize("kind", Slack)
def test_each_slack_costs_its_weight_and_counts_as_its_kind_says(kind: Slack) -> None:
    """A slack of 0.2 costs w (0.2 + 0.2^2) per second; no kind is free, but the view to a chair that looks away."""
    programme = StageProgramme()
    constraints = AreaConstraints(CHAIR, PARAMETERS, programme, AREAS)
    constraints.add_stage(programme, ca.SX.sym("pose", 3), ca.SX.sym("v"), 0.5)
    x = np.zeros(programme.size)
    slacks = x[-len(Slack) :]  # the stage's last variables
    slacks[kind] = 0.2
    cost = ca.Function("cost", [ca.vertcat(*programme.variables), ca.vertcat(*programme.parameters)], [programme.cost])
    costs = []
    for pose in ([-2.0, 0.1, 0.0], [-2.0, 0.1, 3.0]):
        p = np.zeros(programme.parameter_size)
        constraints.set_view(AREAS, np.array(pose), p)
        costs.append(float(cost(x, p)))
    assert costs[0] == pytest.approx(0.5 * getattr(PARAMETERS.weights, kind.weight) * (0.2 + 0.2**2))
    assert costs[1] == pytest.approx(costs[0] if kind is not Slack.VIEW else 0.001 * costs[0])
    assert constraints.violation(x) == (0.2 if kind.is_violation else 0.0)


def test_bay_speed_holds_inside_and_allows_braking_ahead(problem, solver) -> None:
    _, plan = solve(problem, solver, [-1.4, 0.0, 0.0, 0.5, 0.0])
    inside = np.array([np.max(CHAIR.corners_at(pose)[:, 0]) > DOCK.bay.entrance_x for pose in plan.states[:, :3]])
    assert np.any(inside) and np.max(plan.states[inside, 3]) <= CHAIR.limits.v_bay_max + 1e-6
    assert np.max(plan.states[~inside, 3]) > 0.4 and plan.violation < 1e-5


def test_a_marker_stays_in_view(problem, solver) -> None:
    """At least one of the outermost markers, in every pose; where nothing asks for it, none is for some time."""
    start, target = [-1.3, 1.0, -0.6, 0.0, 0.0], [-1.2, 0.0, 0.0]

    def farthest(plan) -> float:
        markers = [relative(target, [*marker.position[:2], 0.0]) for marker in DOCK.markers]
        worst = 0.0
        for pose in plan.states[1:, :3]:
            seen = [relative(pose, marker)[:2] - [CHAIR.camera.x, 0.0] for marker in markers]
            worst = max(worst, min(abs(np.arctan2(y, x)) for x, y in seen))
        return worst

    _, plan = solve(problem, solver, start, AREAS.in_frame(target))
    assert farthest(plan) <= UNKNOWN_CAMERA + 1e-3
    careless = DockingProblem(CHAIR, replace(PARAMETERS, weights=replace(Weights(), view=0.0)), AREAS)
    _, plan = solve(careless, IpoptSolver(careless.functions, IpoptParameters()), start, AREAS.in_frame(target))
    assert farthest(plan) > UNKNOWN_CAMERA + 0.1


def test_a_plan_keeps_clear_of_polygons_that_come_at_run_time(problem, solver) -> None:
    """A box beside the straight way: every pose keeps the margin, though the way without it cuts the corner."""
    box, start = np.array([[-1.75, -0.45], [-1.45, -0.45], [-1.45, -0.15], [-1.75, -0.15]]), [-2.9, 0.0, 0.0, 0.5, 0.0]
    state, states = np.array(start), np.repeat([start], PARAMETERS.horizon + 1, axis=0)

    def nearest(plan) -> float:
        return min(polygon_distance(CHAIR.corners_at(pose), box) for pose in plan.states[1:, :3])

    _, plan = solve(problem, solver, start)
    assert nearest(plan) < 0.0
    for _ in range(6):
        lines = problem.obstacle_lines([box], states)
        solution = solver.solve(problem.data(state, AREAS, lines), WarmStart(problem.guess(states, AREAS)))
        plan = problem.plan(solution.x)
        states = plan.states
        assert solution.status is SolveStatus.SOLVED and plan.violation < 1e-3
        assert nearest(plan) >= PARAMETERS.margin - plan.violation - 1e-4


def test_areas_move_with_the_frame() -> None:
    """A plan seen from another frame has the same clearances: areas in the target's frame are the dock's areas."""
    pose, target = np.array([0.02, 0.17, 0.1]), np.array([-1.2, 0.3, 0.4])
    moved = AREAS.in_frame(target)
    for corner, there in zip(AREAS.corners.corners, moved.corners.corners, strict=True):

        def gap(c, at):
            angle = separating_angle(CHAIR.corners_at(at), c)
            return np.min((CHAIR.corners_at(at) - c.point) @ [np.cos(angle), np.sin(angle)])

        assert gap(there, relative(target, pose)) == pytest.approx(gap(corner, pose), abs=1e-12)
    wall = moved.walls.planes[0]
    point = compose([0.0, 0.0, 0.0], relative(target, [DOCK.bay.back_wall_x, 0.7, 0.0]))[:2]
    assert point @ [np.cos(wall.angle), np.sin(wall.angle)] == pytest.approx(wall.offset)


def test_paper_formulation_docks_roughly() -> None:
    """F1, F2, Euler: moves towards the dock within the speed limits (its accuracy is what the paper says)."""
    parameters = replace(PARAMETERS, formulation="paper", walls=False)
    problem = make_problem(CHAIR, parameters, None)
    solver = make_solver(problem, parameters)
    states = np.zeros((31, 5)) + [-1.0, 0.2, 0.1, 0.0, 0.0]
    solution = solver.solve(problem.data(states[0], None), WarmStart(problem.guess(states, None)))
    plan = problem.plan(solution.x)
    assert solution.violation < 1e-3 and plan.speeds_held
    assert np.max(plan.states[:, 3]) <= CHAIR.limits.v_max + 1e-6
    first = plan.states[0]
    euler = first[:3] + 0.1 * np.array([first[3] * np.cos(0.1), first[3] * np.sin(0.1), first[4]])
    assert plan.states[1, :3] == pytest.approx(euler, abs=1e-3)
    assert np.hypot(*plan.states[-1, :2]) < 0.3


def test_solver_reports_instead_of_raising(problem, solver) -> None:
    data = problem.data(np.zeros(5), AREAS)
    solution = solver.solve(replace(data, p=np.full_like(data.p, np.nan)), WarmStart(np.zeros(data.lbx.size)))
    assert solution.status is not SolveStatus.SOLVED
    stopped = IpoptSolver(problem.functions, replace(IpoptParameters(), max_iterations=1))
    states = np.zeros((31, 5)) + [-3.0, 0.5, 0.0, 0.0, 0.0]
    solution = stopped.solve(problem.data(states[0], AREAS), WarmStart(problem.guess(states, AREAS)))
    assert solution.status is SolveStatus.LIMIT


def test_wall_time_limit_stops_a_solve(problem, solver) -> None:
    states = np.zeros((31, 5)) + [-3.0, 0.5, 0.0, 0.0, 0.0]
    solution = solver.solve(problem.data(states[0], AREAS), WarmStart(problem.guess(states, AREAS)), 1e-3)
    assert solution.status is SolveStatus.LIMIT and solution.solve_time < 0.2
