"""fatrop as CasADi carries it."""

from __future__ import annotations

from typing import ClassVar, Self

import casadi as ca
import numpy as np

from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import ControlParameters, FatropParameters
from seater_nmpc.programme import ProblemData, WarmStart
from seater_nmpc.solve.interface import Array, Solution
from seater_nmpc.solve.nlpsol import run_nlpsol


class FatropSolver:
    """fatrop: an interior point method that factorises stage by stage. No warm start of multipliers.

    The initial state, fixed by its bounds, becomes an equality; the constraints are brought into fatrop's order (of
    each stage the dynamics first). The stages are read off the sparsity of the equalities, so a programme whose
    variables come in the order of the stages is all that is needed. fatrop has no wall-time limit: the iterations are
    limited.
    """

    name: ClassVar[str] = "fatrop"
    takes_coupled_stages: ClassVar[bool] = False  # its factorisation goes from stage to stage

    def __init__(self, functions: dict[str, ca.SX], parameters: FatropParameters) -> None:
        self._functions, self._parameters = functions, parameters
        self._solver: ca.Function | None = None
        self._fixed = self._order = np.zeros(0, dtype=int)

    @classmethod
    def for_problem(cls, problem: Problem, parameters: ControlParameters) -> Self:
        """See Solver."""
        return cls(problem.functions, parameters.fatrop)

    def prepare(self, time_limits: list[float | None]) -> None:
        """Nothing: which variables are fixed comes with the first instance."""

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        fixed = np.flatnonzero(data.lbx == data.ubx)
        if self._solver is None or not np.array_equal(fixed, self._fixed):
            self._fixed = fixed
            self._solver = self._build(data)
        lbx, ubx, zeros = data.lbx.copy(), data.ubx.copy(), np.zeros(len(fixed))
        lbx[fixed], ubx[fixed] = -np.inf, np.inf
        arguments = {
            "x0": np.clip(start.x, data.lbx, data.ubx),
            "p": np.concatenate([data.p, data.lbx[fixed]]),
            "lbx": lbx,
            "ubx": ubx,
            "lbg": np.concatenate([data.lbg, zeros])[self._order],
            "ubg": np.concatenate([data.ubg, zeros])[self._order],
        }
        return run_nlpsol(self._solver, data, arguments, start, self._original)

    def _original(self, result: dict[str, ca.DM]) -> dict[str, ca.DM]:
        """Constraints and multipliers in the order of the programme; the initial state's become those of its bounds."""
        result = dict(result)
        for key in ("g", "lam_g"):
            values = np.empty(len(self._order))
            values[self._order] = result[key].full().ravel()
            if key == "lam_g":
                lam_x = result["lam_x"].full().ravel()
                lam_x[self._fixed] += values[len(values) - len(self._fixed) :]
                result["lam_x"] = ca.DM(lam_x)
            result[key] = ca.DM(values[: len(values) - len(self._fixed)])
        return result

    def _build(self, data: ProblemData) -> ca.Function:
        f = self._functions
        initial = ca.SX.sym("initial", len(self._fixed))
        g = ca.vertcat(f["g"], f["x"][self._fixed.tolist()] - initial)
        equality = np.concatenate([data.lbg == data.ubg, np.ones(len(self._fixed), dtype=bool)])
        inputs, stages = _stages(ca.jacobian(g, f["x"]).sparsity(), equality, len(self._fixed))
        self._order = np.argsort(stages, kind="stable")
        states = [len(self._fixed)] * len(inputs)
        counts = np.bincount(np.floor(stages[~np.isin(stages % 1.0, [0.0])]).astype(int), minlength=len(inputs))
        options = {
            "structure_detection": "manual",
            "N": len(inputs) - 1,
            "nx": states,
            "nu": inputs,
            "ng": counts.tolist(),
            "equality": equality[self._order].tolist(),
            "print_time": False,
            "error_on_fail": False,
            "fatrop.print_level": 0,
            "fatrop.tol": self._parameters.tolerance,
            "fatrop.max_iter": self._parameters.max_iterations,
            "fatrop.mu_init": self._parameters.barrier,
        }
        programme = {"x": f["x"], "p": ca.vertcat(f["p"], initial), "f": f["f"], "g": g[self._order.tolist()]}
        return ca.nlpsol("fatrop", "fatrop", programme, options)


def _stages(jacobian: ca.Sparsity, equality: Array, nx: int) -> tuple[list[int], Array]:
    """Inputs of each stage 0..N, and for each constraint its stage k (dynamics) or k + 0.5 (any other).

    The last `nx` constraints fix the initial state; the other equalities are the dynamics, in groups of nx, with the
    next state as their right-most variables. A constraint belongs to the stage that its left-most variable is in.
    """
    rows, columns = (np.array(values) for values in jacobian.get_triplet())
    left, right = np.full(len(equality), jacobian.size2()), np.zeros(len(equality), dtype=int)
    np.minimum.at(left, rows, columns)
    np.maximum.at(right, rows, columns)
    dynamics = np.flatnonzero(equality[: len(equality) - nx])
    starts = np.concatenate([[0], right[dynamics].reshape(-1, nx).min(axis=1)])
    stages = np.searchsorted(starts, left, side="right") - 0.5
    stages[dynamics] = np.repeat(np.arange(len(starts) - 1), nx)
    inputs = np.diff(np.append(starts, jacobian.size2())) - nx
    return inputs.tolist(), stages
