"""The optimal control problems of docking by multiple shooting, in the target's frame.

The target is the origin, so the heading is wrapped once, by the caller, and nothing wraps or kinks inside (but F2 of the
paper's formulation, which is taken as it is). Formulas: docs/explanation/controller.md.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.ocp.constraints import AreaConstraints
from seater_nmpc.ocp.geometry import Areas
from seater_nmpc.ocp.jerk import JerkLimits
from seater_nmpc.ocp.model import augmented_step, euler_pose_step, step_curvature
from seater_nmpc.ocp.nlp import Plan, ProblemData, StageProgramme
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

_REVERSE_WIDTH = 0.02  # [m/s] over which the price of driving backward sets in


class Problem:
    """What the formulations share; a subclass puts the programme together in `_build`.

    `functions` is the programme for a solver, `refinement` what makes a linearised step honest and `curvature` what the
    constraints add to the cost's Hessian, made convex (None: nothing). A trajectory, in and out,
    has rows (x, y, theta, v, omega).
    """

    speeds_held = False  # whether the speeds of a row hold until the next one (else they change linearly)
    lead = 0.0  # [s] by which what the chair drives is ahead of the prediction, see DockingProblem

    def __init__(self, chair: Chair, parameters: ControlParameters, areas: Areas | None) -> None:
        """`areas` fixes how many prohibited areas there are (None: free space), not where they are."""
        self._chair, self._parameters = chair, parameters
        self._N, self._steps = parameters.horizon, step_lengths(parameters)
        self._z: list[slice] = []
        self._u: list[slice] = []
        self._dynamics: list[int] = []  # rows of g in which the stages' dynamics begin
        programme = StageProgramme()
        self._areas = None if areas is None else AreaConstraints(chair, parameters, programme, areas)
        self._jerk: JerkLimits | None = None
        self._build(programme)
        self.functions = programme.functions()
        self.refinement = self._make_refinement()
        self.curvature = self._make_curvature()
        self._lower, self._upper = np.array(programme.lower), np.array(programme.upper)
        self._columns = np.array([np.arange(where.start, where.stop) for where in self._z])
        self._input_columns = np.array([np.arange(where.start, where.stop) for where in self._u])
        self._g_lower, self._g_upper = np.array(programme.g_lower), np.array(programme.g_upper)
        self._parameter_size = programme.parameter_size

    def data(
        self,
        state: Array,
        areas: Areas | None,
        lines: Array | None = None,
        acceleration: tuple[float, float] = (0.0, 0.0),
    ) -> ProblemData:
        """The instance for the initial state (x, y, theta, v, omega), the areas and the `lines` of obstacles, all in the
        target's frame; `acceleration` (dv/dt, domega/dt) is the last one, for the limits of jerk."""
        lower, upper = self._lower.copy(), self._upper.copy()
        lower[self._z[0]] = upper[self._z[0]] = self._initial(state)
        p = np.zeros(self._parameter_size)
        if self._jerk is not None:
            p[self._jerk.where] = acceleration
        if self._areas is not None and areas is not None:
            self._areas.set_instance(areas, p, lower, upper, lines)
        return ProblemData(p, lower, upper, self._g_lower, self._g_upper)

    def guess(self, states: Array, areas: Areas | None, old: Array | None = None) -> Array:
        """Variables for a trajectory (N + 1, 5); what it does not give is taken from the variables `old` if present."""
        x = np.zeros(self._lower.size)
        self._write_trajectory(states, x)
        if self._areas is not None and areas is not None:
            if old is None:
                self._areas.guess(areas, states, x)
            else:
                self._areas.carry_over(old, x)
        return x

    def obstacle_lines(self, polygons: list[Array], states: Array) -> Array | None:
        """Lines that part the chair, driving along the trajectory `states`, from polygons in the target's frame."""
        return None if self._areas is None else self._areas.obstacle_lines(polygons, states)

    def states(self, x: Array) -> Array:
        """The trajectory (N + 1, 5) in the variables x."""
        return self._read_trajectory(x)

    def plan(self, x: Array) -> Plan:
        """The trajectory in the variables x."""
        violation = 0.0 if self._areas is None else self._areas.violation(x)
        return Plan(
            np.concatenate([[0.0], np.cumsum(self._steps)]), self._read_trajectory(x), violation, self.speeds_held
        )

    def _make_refinement(self) -> ca.Function | None:
        """(x, p, lbx, ubx) -> x with the best parting lines and the smallest sufficient slacks for its poses."""
        if self._areas is None:
            return None
        x, p = self.functions["x"], self.functions["p"]
        lower, upper = (ca.SX.sym(name, x.numel()) for name in ("lbx", "ubx"))
        return ca.Function("refinement", [x, p, lower, upper], [self._areas.refinement(x, lower, upper)])

    def _make_curvature(self) -> ca.Function | None:
        """(x, p, lam_g) -> upper triangle of a positive semidefinite matrix in x."""
        return None

    def _within_speed_limits(self, state: Array) -> Array:
        """The state with speeds inside the bounds, so that the problem is never infeasible from its first stage on."""
        limits, z = self._chair.limits, np.array(state, dtype=float)
        z[3] = np.clip(z[3], -limits.v_reverse_max, limits.v_max)
        z[4] = np.clip(z[4], -limits.omega_max, limits.omega_max)
        return z

    def _speed_bounds(self) -> tuple[list[float], list[float]]:
        limits = self._chair.limits
        return [-limits.v_reverse_max, -limits.omega_max], [limits.v_max, limits.omega_max]

    def _build(self, programme: StageProgramme) -> None:
        raise NotImplementedError

    def _initial(self, state: Array) -> Array:
        raise NotImplementedError

    def _write_trajectory(self, states: Array, x: Array) -> None:
        raise NotImplementedError

    def _read_trajectory(self, x: Array) -> Array:
        raise NotImplementedError


class DockingProblem(Problem):
    """Quadratic stage cost, exact L1 terminal penalty, acceleration limits, soft areas against the whole footprint.

    Variables in the order z0, u0, z1, areas1, u1, ..., zN, areasN, t with z = (x, y, theta, v, omega), u = (dv/dt, domega/dt).

    The prediction's speeds are ramps; the chair holds each command r_k for a control period T from its beginning on, and so
    drives T sum r_k = (ramps) + T/2 (r_n - r_0). Hence p - T/2 r moves as predicted, and the plan starts there (`lead` = T/2).
    Euler steps of length h use the speed at a step's beginning, which is another h/2 late.
    """

    def _build(self, programme: StageProgramme) -> None:
        p = self._parameters
        self.lead = 0.5 * p.control_period + (0.5 * float(self._steps[0]) if p.integrator == "euler" else 0.0)
        low, high = self._speed_bounds()
        low, high = [-math.inf] * 3 + low, [math.inf] * 3 + high
        rate = [self._chair.limits.a_max, self._chair.limits.alpha_max]
        self._jerk = JerkLimits.wanted(p, programme)
        z, where = programme.variable("z0", low, high)
        self._z.append(where)
        for k, h in enumerate(self._steps.tolist()):
            u, where = programme.variable(f"u{k}", [-r for r in rate], rate)
            self._u.append(where)
            programme.cost += h * self._stage_cost(z, u)
            if self._jerk is not None:
                self._jerk.add_stage(programme, u, h)
            z_next, where = programme.variable(f"z{k + 1}", low, high)
            self._z.append(where)
            self._dynamics.append(len(programme.g_lower))
            programme.constrain(z_next - augmented_step(z, u, h, self._parameters.integrator), 0.0, 0.0)
            z = z_next
            if self._areas is not None:
                self._areas.add_stage(programme, z[:3], z[3], h)
        self._terminal_penalty(programme, z)

    def _stage_cost(self, z: ca.SX, u: ca.SX) -> ca.SX:
        w = self._parameters.weights
        backward = 0.5 * (ca.sqrt(z[3] ** 2 + _REVERSE_WIDTH**2) - z[3])
        position = w.x * z[0] ** 2 + w.y * z[1] ** 2 + w.heading * z[2] ** 2
        speed = w.speed * (z[3] ** 2 + z[4] ** 2) + w.reverse * backward**2
        return position + speed + w.acceleration * ca.sumsqr(u)

    def _terminal_penalty(self, programme: StageProgramme, z: ca.SX) -> None:
        """wN (|x| + |y| + c |theta|) with slacks t >= |.|: exact, and smooth where the solver looks."""
        w = self._parameters.weights
        t, self._terminal = programme.variable("t", [0.0] * 3, [math.inf] * 3)
        programme.constrain(t - z[:3], 0.0, math.inf)
        programme.constrain(t + z[:3], 0.0, math.inf)
        programme.cost += w.terminal * (t[0] + t[1] + w.terminal_heading * t[2])

    def _make_curvature(self) -> ca.Function | None:
        x, p, size = self.functions["x"], self.functions["p"], self.functions["x"].numel()
        lam_g, total = ca.SX.sym("lam_g", self.functions["g"].numel()), ca.SX(size, size)
        for row, z, u, h in zip(self._dynamics, self._z[:-1], self._u, self._steps.tolist(), strict=True):
            where = [*range(z.start, z.stop), *range(u.start, u.stop)]
            force = -lam_g[row : row + 2]  # the constraint is z_next - F(z, u)
            total[where, where] += step_curvature(x[z], x[u], force, h, self._parameters.integrator)
        return ca.Function("curvature", [x, p, lam_g], [ca.triu(total)])

    def _initial(self, state: Array) -> Array:
        return self._within_speed_limits(state)

    def _write_trajectory(self, states: Array, x: Array) -> None:
        x[self._columns] = states
        x[self._input_columns] = np.diff(states[:, 3:], axis=0) / self._steps[:, None]
        x[self._terminal] = np.abs(states[-1, :3])

    def _read_trajectory(self, x: Array) -> Array:
        return x[self._columns]


class PaperProblem(Problem):
    """The paper's formulation: poses and u = (v, omega), Euler steps, F1 and F2 weighted by Q and P, inputs by R.

    F2 = pi - ||phi - phi_doc| - pi|. No acceleration limits; areas (if any) as in DockingProblem.
    """

    speeds_held = True

    def _build(self, programme: StageProgramme) -> None:
        w, free = self._parameters.paper, [math.inf] * 3
        pose, where = programme.variable("x0", [-math.inf] * 3, free)
        self._z.append(where)
        for k, h in enumerate(self._steps.tolist()):
            u, where = programme.variable(f"u{k}", *self._speed_bounds())
            self._u.append(where)
            programme.cost += _paper_cost(pose, w.Q_position, w.Q_heading) + w.R_v * u[0] ** 2 + w.R_omega * u[1] ** 2
            following, where = programme.variable(f"x{k + 1}", [-math.inf] * 3, free)
            self._z.append(where)
            programme.constrain(following - euler_pose_step(pose, u[0], u[1], h), 0.0, 0.0)
            pose = following
            if self._areas is not None:
                self._areas.add_stage(programme, pose, u[0], h)
        programme.cost += _paper_cost(pose, w.P_position, w.P_heading)

    def _initial(self, state: Array) -> Array:
        return np.array(state[:3], dtype=float)

    def _write_trajectory(self, states: Array, x: Array) -> None:
        x[self._columns] = states[:, :3]
        x[self._input_columns] = states[:-1, 3:]

    def _read_trajectory(self, x: Array) -> Array:
        return np.hstack([x[self._columns], np.vstack([x[self._input_columns], np.zeros(2)])])


def _paper_cost(pose: ca.SX, position: float, heading: float) -> ca.SX:
    F1 = ca.sumsqr(pose[:2])
    F2 = math.pi - ca.fabs(ca.fabs(pose[2]) - math.pi)
    return position * F1 + heading * F2


def step_lengths(parameters: ControlParameters) -> Array:
    """Length of each step of the prediction [s], (N,): the first `fine_steps` as long as the control period, the others
    growing evenly from `step` to `last_step` (if any)."""
    fine = min(parameters.fine_steps, parameters.horizon)
    others = np.linspace(parameters.step, parameters.last_step or parameters.step, parameters.horizon - fine)
    return np.concatenate([np.full(fine, parameters.control_period), others])


def make_problem(chair: Chair, parameters: ControlParameters, areas: Areas | None) -> Problem:
    """The formulation that the parameters name."""
    makers = {"docking": DockingProblem, "paper": PaperProblem}
    if parameters.formulation not in makers:
        raise ValueError(f"control/formulation: is {parameters.formulation!r}, must be one of {', '.join(makers)}")
    return makers[parameters.formulation](chair, parameters, areas)
