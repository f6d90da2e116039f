"""The programme linearised at a point, and its quadratic programme solved by PIQP.

One CasADi function returns the whole linearisation into buffers that PIQP's sparse matrices are views of. The Hessian
is the cost's own, which is convex here, and of the dynamics' curvature (weighted with the last multipliers) the convex
part: without it, as Gauss-Newton does, full steps swing where the terminal penalty is high and the inputs are cheap.
"""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import piqp
from scipy.sparse import csc_matrix

from seater_nmpc.parameters import RtiParameters
from seater_nmpc.programme import ProblemData
from seater_nmpc.solve.buffered_function import BufferedFunction
from seater_nmpc.solve.interface import Array

_QP_ITERATIONS = 60  # of PIQP; some ten are the rule


class NoStepError(Exception):
    """There is no usable step; the text says why."""


class QuadraticModel:
    """The programme linearised at a point, as PIQP takes it: min 1/2 d'Pd + c'd, A d = b, h_l <= G d <= h_u, bounds.

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
        # a proximal term where the cost has no curvature (the angles of the separating lines): the steps stay small,
        # the solution stays where it is
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
