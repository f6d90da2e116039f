"""One stage of the docking problem, as seater_nmpc writes it, in the form in which acados takes stages."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.ocp.areas import Areas, dock_areas
from seater_nmpc.ocp.constraints.interface import Slack
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.ocp.model import INPUT_SIZE, STATE_SIZE
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

LINE_SIZE = 7  # numbers of an obstacle's line, see ObstacleConstraint
_STEPS = INPUT_SIZE + STATE_SIZE  # where in x of a horizon of one step the state after the step ends, after z0 and u


@dataclass(frozen=True)
class DockingStage:
    """Everything is cut out of seater_nmpc's own problem with a horizon of one step, so that it cannot differ.

    acados has a stage's constraints where its state and inputs meet, and no inputs at the last state; the docking
    problem has separating lines and slacks at the states 1..N. So the inputs of a stage are (accelerations, angles of
    the lines, slacks) of its state, and one more stage follows, `active` = 0, which goes nowhere and costs what its own
    slacks cost. Its accelerations are 0 in the solution.
    """

    z: ca.SX  # (5,) x, y, heading, v, omega
    inputs: ca.SX  # (7,) dv/dt, domega/dt, two angles, three slacks
    p: ca.SX  # where the areas are, and at the end `active`
    following: ca.SX  # (5,) the next state
    cost: ca.SX  # per second
    margins: ca.SX  # not negative where all areas are kept
    terminal: Array  # (3,) weights of |x|, |y|, |heading| at the end
    areas: Array  # p of the bay, without obstacles and `active`
    lines: slice  # where the obstacles' lines of the stage stand in p
    lower: Array  # bounds (7,) of the inputs at the states 1..N
    upper: Array
    speeds: tuple[Array, Array]  # bounds (2,) of v and omega
    angles: int  # how many of the inputs are angles of separating lines
    step: float  # [s]


def docking_stage(chair: Chair, dock: Dock, parameters: ControlParameters) -> DockingStage:
    """The stage for the docking pose as target.

    Raises:
        ValueError: parameters with which the stages are not all alike.
    """
    p = parameters
    if p.fine_steps or p.last_step or p.formulation != "docking" or not p.walls or p.max_jerk or p.max_angular_jerk:
        raise ValueError("acados: only the formulation `docking` with walls, equal steps and no limits of jerk")
    areas = dock_areas(dock)
    one = DockingProblem(chair, replace(parameters, horizon=1), areas)
    x, symbol, f, g = (one.functions[key] for key in ("x", "p", "f", "g"))
    data = one.data(np.zeros(STATE_SIZE), areas)
    after = slice(_STEPS, _STEPS + STATE_SIZE)
    own = slice(after.stop, x.numel() - 3)  # angles and slacks; then the terminal penalty's three
    whole = ca.Function("one", [x, symbol], [f, g])
    z, inputs = ca.SX.sym("z", STATE_SIZE), ca.SX.sym("inputs", INPUT_SIZE + own.stop - own.start)
    active, areas_of_stage = ca.SX.sym("active"), ca.SX.sym("areas", symbol.numel())
    u, mine, nowhere = inputs[:INPUT_SIZE], inputs[INPUT_SIZE:], ca.SX.zeros(3)
    # Cost of driving on from here, without that of the slacks; that of the slacks; the margins, all with our functions.
    driving, dynamics = whole(ca.vertcat(z, u, ca.SX.zeros(x.numel() - _STEPS)), areas_of_stage)
    standing = whole(ca.vertcat(ca.SX.zeros(_STEPS), z, mine, nowhere), areas_of_stage)
    nothing = float(whole(np.zeros(x.numel()), data.p)[0])
    acceleration = p.step * p.weights.acceleration * ca.sumsqr(u)  # also where nothing is driven: keeps them at zero
    cost = active * (driving - acceleration) + acceleration + standing[0] - nothing
    following = z + active * (-dynamics[:STATE_SIZE] - z)
    return DockingStage(
        z=z,
        inputs=inputs,
        p=ca.vertcat(areas_of_stage, active),
        following=following,
        cost=cost / p.step,
        margins=standing[1][STATE_SIZE:-6],
        terminal=p.weights.terminal * np.array([1.0, 1.0, p.weights.terminal_heading]),
        areas=data.p,
        lines=_lines_of(one, areas, p.max_obstacles),
        lower=np.concatenate([data.lbx[STATE_SIZE:_STEPS], data.lbx[own]]),
        upper=np.concatenate([data.ubx[STATE_SIZE:_STEPS], data.ubx[own]]),
        speeds=(data.lbx[after][3:], data.ubx[after][3:]),
        angles=own.stop - own.start - len(Slack),
        step=p.step,
    )


def _lines_of(one: DockingProblem, areas: Areas, slots: int) -> slice:
    """Where the lines of obstacles stand in the parameters: what changes with them."""
    p = one.data(np.zeros(STATE_SIZE), areas, np.full((1, slots, LINE_SIZE), math.nan)).p
    where = np.flatnonzero(np.isnan(p))
    return slice(int(where[0]), int(where[-1]) + 1) if len(where) else slice(0, 0)


def to_stages(x: Array, stage: DockingStage, horizon: int) -> tuple[Array, Array]:
    """(states (N + 1, 5), inputs (N + 1, 7)) of acados for variables x in DockingProblem's order."""
    size = STATE_SIZE + len(stage.lower)
    rows = x[STATE_SIZE : STATE_SIZE + horizon * size].reshape(horizon, size)
    inputs = np.zeros((horizon + 1, len(stage.lower)))
    inputs[0, INPUT_SIZE:] = np.where(np.isfinite(stage.upper), 0.5 * (stage.lower + stage.upper), 0.0)[INPUT_SIZE:]
    inputs[:-1, :INPUT_SIZE], inputs[1:, INPUT_SIZE:] = rows[:, :INPUT_SIZE], rows[:, INPUT_SIZE + STATE_SIZE :]
    return np.vstack([x[:STATE_SIZE], rows[:, INPUT_SIZE : INPUT_SIZE + STATE_SIZE]]), inputs


def from_stages(states: Array, inputs: Array) -> Array:
    """The inverse of `to_stages`."""
    rows = np.hstack([inputs[:-1, :INPUT_SIZE], states[1:], inputs[1:, INPUT_SIZE:]])
    return np.concatenate([states[0], rows.ravel(), np.abs(states[-1, :3])])
