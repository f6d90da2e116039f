"""Sequential quadratic programming in real time: one quadratic programme per control cycle (Diehl, Bock, Schloeder 2005).

One CasADi function returns the whole linearisation into buffers that PIQP's sparse matrices are views of. The Hessian is the
cost's own, which is convex here, and of the dynamics' curvature (weighted with the last multipliers) the convex part: without
it, as Gauss-Newton does, full steps swing where the terminal penalty is high and the inputs are cheap.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from seater_nmpc.solve.solver_interface import Array, Solution, Solver, SolveStatus, all_finite, failed  # isort: skip

import casadi as ca
import numpy as np
import piqp
from scipy.sparse import csc_matrix

from seater_nmpc.ocp.nlp import ProblemData, WarmStart
from seater_nmpc.parameters import RtiParameters
from seater_nmpc.solve.buffered_function import BufferedFunction

_QP_ITERATIONS = 60  # of PIQP; some ten are the rule
_SHARES = (1.0, 0.5, 0.25)  # of a step that are tried
_RISE = 1.0  # by which cost and open constraints may grow in a step, relative and absolute: full steps are the rule


class NoStepError(Exception):
    """There is no usable step; the text says why."""


class QuadraticModel:
    """The programme linearised at a point, as PIQP takes it: minimise 1/2 d'Pd + c'd, A d = b, h_l <= G d <= h_u, bounds.

    Variables that the bounds fix (the initial state) are not part of it. The sparsity never changes.
    """

    def __init__(
        self,
        functions: dict[str, ca.SX],
        data: ProblemData,
        parameters: RtiParameters,
        refinement: ca.Function | None = None,
        curvature: ca.Function | None = None,
    ) -> None:
        """`data` says which variables are fixed and which constraints are equalities."""
        x, p, f, g = (functions[key] for key in ("x", "p", "f", "g"))
        self.free = np.flatnonzero(data.lbx != data.ubx)
        self.equal, self.unequal = np.flatnonzero(data.lbg == data.ubg), np.flatnonzero(data.lbg != data.ubg)
        free = self.free.tolist()
        hessian, gradient = ca.hessian(f, x)
        lam_g = ca.SX.sym("lam_g", g.numel())
        hessian = ca.triu(hessian) if curvature is None else ca.triu(hessian) + curvature(x, p, lam_g)
        hessian = hessian[free, free]
        # a proximal term where the cost has no curvature (the angles of the parting lines): the steps stay small, the
        # solution stays where it is
        flat = [hessian.sparsity().has_nz(i, i) for i in range(len(free))]
        hessian += ca.diag(ca.sparsify(ca.DM([0.0 if curved else parameters.proximal for curved in flat])))
        jacobian = ca.jacobian(g, x)
        A, G = jacobian[self.equal.tolist(), free], jacobian[self.unequal.tolist(), free]
        nonzeros = [m.nz[:] for m in (hessian, A, G)]
        self._linearise = BufferedFunction(ca.Function("linearise", [x, p, lam_g], [*nonzeros, gradient[free], g]))
        self._values = BufferedFunction(_values(x, p, f, g, refinement))
        P_nz, A_nz, G_nz, self._c, self._g = self._linearise.outputs
        self._P, self._A, self._G = _matrix(hessian, P_nz), _matrix(A, A_nz), _matrix(G, G_nz)
        self._parameters = parameters
        self._qp: piqp.SparseSolver | None = None

    def forget(self) -> None:
        """A new goal begins: the scaling that the last one left is not handed on, so that each comes out the same."""
        self._qp = None

    def refined(self, x: Array, data: ProblemData) -> tuple[Array, float, Array]:
        """x put into its bounds and refined, cost and constraints there (views, overwritten by the next call)."""
        x, f, g = self._values(np.minimum(np.maximum(x, data.lbx), data.ubx), data.p, data.lbx, data.ubx)
        return x, float(f[0]), g

    def step(self, x: Array, lam_g: Array, data: ProblemData) -> piqp.Result:
        """The quadratic programme's solution at x with the multipliers lam_g. Raises NoStepError."""
        self._linearise(x, data.p, lam_g)
        if not all(math.isfinite(np.dot(values, values)) for values in self._linearise.outputs):
            raise NoStepError("linearisation not finite")
        free, lower, upper = self.free, data.lbg - self._g, data.ubg - self._g
        arguments = (
            self._P,
            self._c,
            self._A,
            lower[self.equal],
            self._G,
            lower[self.unequal],
            upper[self.unequal],
            (data.lbx - x)[free],
            (data.ubx - x)[free],
        )
        if self._qp is None:
            self._qp = _quadratic_solver(self._parameters)
            self._qp.setup(*arguments)
        else:
            self._qp.update(*arguments)
        status = self._qp.solve()
        if status not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
            self._qp = None  # whatever is left in it does not reach the next solve
            raise NoStepError(f"quadratic programme: {status}")
        result = self._qp.result
        if not np.isfinite(np.dot(result.x, result.x)):
            self._qp = None
            raise NoStepError("quadratic programme: not finite")
        return result


class RtiSolver:
    """Newton steps from the last plan, in full where that does no harm; a cold start (no multipliers) is left to `converging`.

    A cycle takes `iterations` steps, and further ones, up to `max_iterations`, while the constraints are open by more than
    `feasibility`; but after the first one only while time remains.
    """

    name = "rti"

    def __init__(
        self,
        functions: dict[str, ca.SX],
        parameters: RtiParameters,
        converging: Solver,
        refinement: ca.Function | None = None,
        curvature: ca.Function | None = None,
    ) -> None:
        self._functions, self._parameters = functions, parameters
        self._converging, self._refinement, self._curvature = converging, refinement, curvature
        self._model: QuadraticModel | None = None
        self._fixed: Array = np.zeros(0)

    def prepare(self, time_limits: list[float | None]) -> None:
        """See Solver. The linearisation is built in the first solve, which knows what is fixed."""
        self._converging.prepare(time_limits)

    def solve(self, data: ProblemData, start: WarmStart, time_limit: float | None = None) -> Solution:
        """See Solver."""
        fixed = data.lbx == data.ubx
        if self._model is None or not np.array_equal(fixed, self._fixed):
            self._model = QuadraticModel(self._functions, data, self._parameters, self._refinement, self._curvature)
            self._fixed = fixed
        if start.lam_x is None or start.lam_g is None:
            self._model.forget()
            return self._converging.solve(data, start, time_limit)
        begin = time.perf_counter()
        try:
            return self._iterate(self._model, data, start.x, start.lam_g.copy(), begin, time_limit)
        except NoStepError as reason:
            return failed(start, time.perf_counter() - begin, str(reason))

    def _iterate(
        self, model: QuadraticModel, data: ProblemData, x: Array, lam_g: Array, begin: float, limit: float | None
    ) -> Solution:
        p, count, began, lam_x = self._parameters, 0, begin, np.zeros(len(data.lbx))
        here = _iterate_at(model, x, data)
        while True:
            result = model.step(here.x, lam_g, data)
            here = self._advanced(model, data, here, result, lam_g)
            gap, count, now = here.gap, count + 1, time.perf_counter()
            if count >= (p.iterations if gap <= p.feasibility else max(p.iterations, p.max_iterations)):
                break
            if limit is not None and now - begin + 1.5 * (now - began) > limit:  # the next one would be late
                break
            began = now
        x, cost = here.x, here.cost
        lam_x[model.free] = result.z_bu - result.z_bl
        if not all_finite(0.0, lam_x, lam_g):
            raise NoStepError("multipliers not finite")
        status = SolveStatus.SOLVED if gap <= p.feasibility else SolveStatus.LIMIT
        text = f"quadratic programme: {result.info.iter} iterations, longest step {np.max(np.abs(result.x)):.1e}"
        return Solution(status, x, lam_x, lam_g, cost, max(0.0, gap), count, time.perf_counter() - begin, text)

    @staticmethod
    def _advanced(
        model: QuadraticModel, data: ProblemData, here: _Iterate, result: piqp.Result, lam_g: Array
    ) -> _Iterate:
        """The point after the step, or after a part of it where the whole one makes cost plus open constraints much worse.

        That happens where the linearisation shows the way across a bend: two points would alternate. Updates lam_g.
        """
        multipliers = np.empty_like(lam_g)
        multipliers[model.equal], multipliers[model.unequal] = result.y, result.z_u - result.z_l
        price = float(np.max(np.abs(multipliers)))
        bound, best, least, taken = _worth(here, price) * (1.0 + _RISE) + _RISE, here, math.inf, 1.0
        for share in _SHARES:
            x = here.x.copy()
            x[model.free] += share * result.x
            there = _iterate_at(model, x, data)
            worth = _worth(there, price)
            if worth < least:
                best, least, taken = there, worth, share
            if worth <= bound:
                break
        lam_g += taken * (multipliers - lam_g)
        return best


def _worth(at: _Iterate, price: float) -> float:
    """Exact penalty function: cost plus open constraints at the largest multiplier."""
    return at.cost + price * at.total_gap


@dataclass(frozen=True)
class _Iterate:
    """A refined point: the honest cost, and by how much the constraints are open, at most and in all."""

    x: Array
    cost: float
    gap: float
    total_gap: float


def _iterate_at(model: QuadraticModel, x: Array, data: ProblemData) -> _Iterate:
    """The point x, refined. Raises NoStepError where anything is not finite."""
    x, cost, g = model.refined(x, data)
    amount = np.maximum(np.maximum(data.lbg - g, g - data.ubg), 0.0)
    gap, total_gap = float(np.max(amount)), float(np.sum(amount))
    if not math.isfinite(total_gap + cost + float(np.dot(x, x))):
        raise NoStepError("iterate not finite")
    return _Iterate(x.copy(), cost, gap, total_gap)


def _values(x: ca.SX, p: ca.SX, f: ca.SX, g: ca.SX, refinement: ca.Function | None) -> ca.Function:
    """(x, p, lbx, ubx) -> refined x, f and g there."""
    lower, upper = (ca.SX.sym(name, x.numel()) for name in ("lbx", "ubx"))
    at, fg = ca.SX(x) if refinement is None else refinement(x, p, lower, upper), ca.Function("fg", [x, p], [f, g])
    return ca.Function("values", [x, p, lower, upper], [ca.densify(at), *fg(at, p)])


def _matrix(expression: ca.SX, nonzeros: Array) -> csc_matrix:
    """A sparse matrix whose values are a view of `nonzeros`."""
    sparsity = expression.sparsity()
    rows, columns = (np.array(values, dtype=np.int32) for values in (sparsity.row(), sparsity.colind()))
    return csc_matrix((nonzeros, rows, columns), shape=expression.shape)


def _quadratic_solver(parameters: RtiParameters) -> piqp.SparseSolver:
    qp = piqp.SparseSolver()
    qp.settings.eps_abs, qp.settings.eps_rel = parameters.tolerance, parameters.tolerance
    qp.settings.check_duality_gap = False
    qp.settings.max_iter = _QP_ITERATIONS
    qp.settings.kkt_solver = piqp.KKTSolver.sparse_ldlt_cond  # grows least with the horizon
    qp.settings.preconditioner_reuse_on_update = True
    return qp
