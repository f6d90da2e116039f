"""All areas together as soft constraints of a stage-wise programme."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.ocp.areas import Areas
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Indices, Slack, Stage, columns
from seater_nmpc.ocp.constraints.obstacles import ObstacleConstraint
from seater_nmpc.ocp.constraints.view import ViewConstraint
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]

_LOOKING_AWAY = 1e-3  # share of the view's weight for a chair that looks away from the markers
_VIOLATIONS = [int(kind) for kind in Slack if kind.is_violation]
# The kinds of slack under each penalty weight.
_PENALISED = {weight: [int(kind) for kind in Slack if kind.weight == weight] for weight in (k.weight for k in Slack)}


@dataclass(frozen=True)
class _BuiltStage:
    """A stage and, for each slack, the margins that it makes soft."""

    stage: Stage
    margins: list[ca.SX]


class AreaConstraints:
    """Every stage has the variables of its constraints and one slack of each kind, each slack with an exact penalty
    weight, so that nothing is ever infeasible."""

    def __init__(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme, areas: Areas) -> None:
        """`areas` fixes how many parts each kind has; where they are comes with each instance."""
        self._chair, self._weights = chair, parameters.weights
        self._fixed: list[AreaConstraint[Any]] = [area.constraint(chair, parameters, programme) for area in areas.parts]
        self._views = [constraint for constraint in self._fixed if isinstance(constraint, ViewConstraint)]
        self._obstacles = ObstacleConstraint(chair, parameters, programme)
        self._constraints = [*self._fixed, self._obstacles]
        self._view, self._view_at = programme.parameter("view_counts", 1)
        self._slacks: list[slice] = []
        self._stages: list[_BuiltStage] = []
        self._columns: tuple[Indices, Indices] | None = None

    def add_stage(self, programme: StageProgramme, pose: ca.SX, v: ca.SX, step: float) -> None:
        """Constrain the footprint at the pose (3,) and the speed v there, at the end of a step of length `step` [s]."""
        for constraint in self._constraints:
            constraint.add_variables(programme)
        slack, where = programme.variable("s", [0.0] * len(Slack), [math.inf] * len(Slack))
        self._slacks.append(where)
        stage = Stage(len(self._stages), pose, v, _footprint(self._chair, pose))
        margins = []
        for kind in Slack:
            of_kind = [margin for c in self._constraints if c.slack is kind for margin in c.margins(stage)]
            for margin in of_kind:
                programme.constrain(margin + slack[int(kind)], 0.0, math.inf)
            margins.append(ca.vertcat(*of_kind))
        for weight, kinds in _PENALISED.items():
            counts = self._view if weight == Slack.VIEW.weight else 1.0
            penalty = ca.sum1(slack[kinds]) + ca.sumsqr(slack[kinds])
            programme.cost += step * getattr(self._weights, weight) * counts * penalty
        self._stages.append(_BuiltStage(stage, margins))

    def refinement(self, x: ca.SX, lower: ca.SX, upper: ca.SX) -> ca.SX:
        """The variables x with, for their poses, the constraints' best variables and the smallest sufficient slacks.

        What a linearisation says about separating lines and slacks holds near its point only; this is true of the
        iterate.
        """
        x, flexible = ca.SX(x), [constraint for constraint in self._constraints if constraint.symbols]
        for k, built in enumerate(self._stages):
            for constraint in flexible:
                x[constraint.places[k]] = constraint.best(built.stage, lower, upper)
            symbols = [constraint.symbols[k] for constraint in flexible]
            best = [x[constraint.places[k]] for constraint in flexible]
            margins = ca.substitute(built.margins, symbols, best) if flexible else built.margins
            x[self._slacks[k]] = ca.vertcat(*[ca.fmax(0.0, -ca.mmin(margin)) for margin in margins])
        return x

    def set_areas(self, areas: Areas, p: Array, lower: Array, upper: Array) -> None:
        """Write where the areas are into the parameters and the bounds."""
        for constraint, area in zip(self._fixed, areas.parts, strict=True):
            constraint.set_instance(area, p, lower, upper)

    def set_view(self, areas: Areas, pose: Array, p: Array) -> None:
        """Write how much the view counts for a chair that begins at `pose` (3,) into the parameters."""
        away = any(view.looks_away(areas.view, pose) for view in self._views)
        p[self._view_at] = _LOOKING_AWAY if away else 1.0

    def set_lines(self, lines: Array | None, p: Array, lower: Array, upper: Array) -> None:
        """Write the `obstacle_lines` (None: none) into the parameters."""
        self._obstacles.set_instance(lines, p, lower, upper)

    def obstacle_lines(self, polygons: list[Array], states: Array) -> Array:
        """See ObstacleConstraint.lines."""
        return self._obstacles.lines(polygons, states)

    def guess(self, areas: Areas, states: Array, x: Array) -> None:
        """Write an initial guess of the constraints' variables for the poses of `states` (N + 1, >= 3) into x."""
        for constraint, area in zip(self._fixed, areas.parts, strict=True):
            constraint.guess(area, states, x)

    def carry_over(self, old: Array, x: Array) -> None:
        """Copy the constraints' variables and slacks of an earlier solution."""
        for where in self._index():
            x[where] = old[where]

    def violation(self, x: Array) -> float:
        """Largest violation of an area or the bay's speed in the plan [m or m/s]; the view is a wish, not counted."""
        return max(0.0, float(np.max(x[self._index()[1][:, _VIOLATIONS]])))

    def _index(self) -> tuple[Indices, Indices]:
        """Where the constraints' variables (flat) and the slacks (N, kinds) stand in x."""
        if self._columns is None:
            own = [columns(constraint.places).ravel() for constraint in self._constraints]
            self._columns = np.concatenate(own), columns(self._slacks)
        return self._columns


def _footprint(chair: Chair, pose: ca.SX) -> ca.SX:
    """Corners of the footprint, (4, 2), of the chair at the pose."""
    c, s = ca.cos(pose[2]), ca.sin(pose[2])
    rotation = ca.vertcat(ca.horzcat(c, s), ca.horzcat(-s, c))
    return ca.DM(chair.corners()) @ rotation + ca.repmat(pose[:2].T, 4, 1)
