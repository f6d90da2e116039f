"""What the optimal control problems of docking share: multiple shooting (formulas: docs/explanation/controller.md).

The target is the origin, so the heading is wrapped once, by the caller, and nothing wraps or kinks inside (but F2 of
the paper's formulation, which is taken as it is).
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.ocp.area_constraints import AreaConstraints
from seater_nmpc.ocp.areas import Areas
from seater_nmpc.ocp.jerk import JerkLimits
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import Plan, ProblemData, StageProgramme

Array = NDArray[np.float64]

_EASILY = 0.9  # fraction of the largest deceleration with which a new limit of speed is reached


class Problem(ABC):
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
        self._steps = step_lengths(parameters)
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
        self._instance: tuple[Areas | None, tuple[Array, Array, Array]] | None = None
        self._times = np.concatenate([[0.0], np.cumsum(self._steps)])

    @property
    def couples_stages(self) -> bool:
        """Whether constraints bind the inputs of neighbouring stages to each other."""
        return self._jerk is not None

    def data(
        self,
        state: Array,
        areas: Areas | None,
        lines: Array | None = None,
        acceleration: tuple[float, float] = (0.0, 0.0),
        slow: tuple[float, float] | None = None,
    ) -> ProblemData:
        """The instance for the initial state (x, y, theta, v, omega), the areas and the `lines` of obstacles, all in
        the target's frame; `acceleration` (dv/dt, domega/dt) is the last one, for the limits of jerk; `slow`: limits
        of |v| and |omega| that hold as soon as the chair can have slowed down to them."""
        p, lower, upper = (values.copy() for values in self._at(areas))
        initial = self._initial(state)
        if slow is not None:
            self._slow_down(initial, slow, lower, upper)
        lower[self._z[0]] = upper[self._z[0]] = initial
        if self._jerk is not None:
            p[self._jerk.where] = acceleration
        if self._areas is not None and areas is not None:
            self._areas.set_lines(lines, p, lower, upper)
            self._areas.set_view(areas, initial[:3], p)
        return ProblemData(p=p, lbx=lower, ubx=upper, lbg=self._g_lower, ubg=self._g_upper)

    def _slow_down(self, initial: Array, slow: tuple[float, float], lower: Array, upper: Array) -> None:
        rates, limits = (self._chair.limits.a_max, self._chair.limits.alpha_max), self._slow_columns()
        for columns, start, limit, rate in zip(limits, initial[-2:], slow, rates, strict=True):
            reachable = np.maximum(limit, abs(float(start)) - _EASILY * rate * self._times[-len(columns) :])
            upper[columns] = np.minimum(upper[columns], reachable)
            lower[columns] = np.maximum(lower[columns], -reachable)

    def _slow_columns(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Where v and omega of the stages after the first stand in the variables."""
        none = np.zeros(0, dtype=np.intp)
        return none, none

    def _at(self, areas: Areas | None) -> tuple[Array, Array, Array]:
        """Parameters and bounds where the areas are; kept, for an instance comes each cycle and the areas stay."""
        if self._instance is None or self._instance[0] is not areas:
            p, lower, upper = np.zeros(self._parameter_size), self._lower.copy(), self._upper.copy()
            if self._areas is not None and areas is not None:
                self._areas.set_areas(areas, p, lower, upper)
            self._instance = areas, (p, lower, upper)
        return self._instance[1]

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
        """Lines that separate the chair, driving along the trajectory `states`, from polygons in the target's frame."""
        return None if self._areas is None else self._areas.obstacle_lines(polygons, states)

    def states(self, x: Array) -> Array:
        """The trajectory (N + 1, 5) in the variables x."""
        return self._read_trajectory(x)

    def plan(self, x: Array) -> Plan:
        """The trajectory in the variables x."""
        violation = 0.0 if self._areas is None else self._areas.violation(x)
        return Plan(
            times=self._times,
            states=self._read_trajectory(x),
            violation=violation,
            speeds_held=self.speeds_held,
        )

    def _make_refinement(self) -> ca.Function | None:
        """(x, p, lbx, ubx) -> x with the best separating lines and the smallest sufficient slacks for its poses."""
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

    @abstractmethod
    def _build(self, programme: StageProgramme) -> None:
        """Add all variables, constraints and the cost, stage by stage."""

    @abstractmethod
    def _initial(self, state: Array) -> Array:
        """Values of the first stage's state variables for the state (5,)."""

    @abstractmethod
    def _write_trajectory(self, states: Array, x: Array) -> None:
        """Write the trajectory (N + 1, 5) into the variables x."""

    @abstractmethod
    def _read_trajectory(self, x: Array) -> Array:
        """The trajectory (N + 1, 5) in the variables x."""


def step_lengths(parameters: ControlParameters) -> Array:
    """Length of each step of the prediction [s], (N,): the first `fine_steps` as long as the control period, the others
    growing evenly from `step` to `last_step` (if any)."""
    fine = min(parameters.fine_steps, parameters.horizon)
    others = np.linspace(parameters.step, parameters.last_step or parameters.step, parameters.horizon - fine)
    return np.concatenate([np.full(fine, parameters.control_period), others])
