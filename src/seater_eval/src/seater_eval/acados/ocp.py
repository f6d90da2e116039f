"""The docking problem as an acados OCP. Only the worker, in which acados can be imported, calls this."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from seater_eval.acados.stage import DockingStage
from seater_nmpc.ocp.model import INPUT_SIZE
from seater_nmpc.parameters import ControlParameters

_FAR = 1e3  # a bound that never holds: acados of this version has no one-sided constraints

# What was quickest on this problem: `SPEED` takes 1.6 ms where `BALANCE` takes 2.0, with the same iterates; partial
# condensing to 10 stages 2.1; exact Hessian of the dynamics, mirrored, 2.2 (docs/results/controller.md).
OPTIONS: dict[str, Any] = {
    "qp_solver": "PARTIAL_CONDENSING_HPIPM",
    "nlp_solver_type": "SQP_RTI",
    "hessian_approx": "GAUSS_NEWTON",
    "hpipm_mode": "SPEED",
    "qp_solver_iter_max": 50,
    "ext_fun_compile_flags": "-O3 -march=native",
}


def make_solver(stage: DockingStage, parameters: ControlParameters, folder: Path) -> Any:
    """An AcadosOcpSolver; its code is generated and compiled in `folder`."""
    at: Any = importlib.import_module("acados_template")  # by name: no dependency of the package

    model, ocp = at.AcadosModel(), at.AcadosOcp()
    model.name, model.x, model.u, model.p = "docking", stage.z, stage.inputs, stage.p
    model.disc_dyn_expr, model.con_h_expr = stage.following, stage.margins
    model.cost_expr_ext_cost = stage.cost
    model.cost_expr_ext_cost_custom_hess = _convex_hessian(stage, parameters)
    ocp.model, ocp.dims.N = model, parameters.horizon + 1
    ocp.cost.cost_type, ocp.cost.cost_type_e = "EXTERNAL", "LINEAR_LS"
    _set_terminal(ocp, stage)
    _set_constraints(ocp, stage)
    ocp.parameter_values = np.concatenate([stage.areas, [1.0]])
    ocp.code_export_directory = str(folder / "code")
    settings = ocp.solver_options
    settings.tf, settings.integrator_type = ocp.dims.N * stage.step, "DISCRETE"
    for name, value in OPTIONS.items():
        setattr(settings, name, value)
    solver = at.AcadosOcpSolver(ocp, json_file=str(folder / "docking.json"), verbose=False)
    solver.constraints_set(0, "lh", np.full(stage.margins.numel(), -_FAR))  # the first state is what it is
    solver.set(parameters.horizon, "p", np.concatenate([stage.areas, [0.0]]))
    return solver


def _convex_hessian(stage: DockingStage, parameters: ControlParameters) -> ca.SX:
    """The cost's own, which is convex, and the proximal weight on the angles of the lines, as in the solver `rti`."""
    hessian, _ = ca.hessian(stage.cost, ca.vertcat(stage.inputs, stage.z))
    for i in range(INPUT_SIZE, INPUT_SIZE + stage.angles):
        hessian[i, i] += parameters.rti.proximal / stage.step
    return hessian


def _set_terminal(ocp: Any, stage: DockingStage) -> None:
    """The exact penalty: pose = 0, softly, with linear weights of the slacks to both sides."""
    ocp.cost.Vx_e, ocp.cost.W_e, ocp.cost.yref_e = np.zeros((0, 5)), np.zeros((0, 0)), np.zeros(0)
    ocp.cost.zl_e = ocp.cost.zu_e = stage.terminal
    ocp.cost.Zl_e = ocp.cost.Zu_e = np.zeros(3)
    ocp.constraints.idxbx_e = ocp.constraints.idxsbx_e = np.arange(3)
    ocp.constraints.lbx_e = ocp.constraints.ubx_e = np.zeros(3)


def _set_constraints(ocp: Any, stage: DockingStage) -> None:
    c, count = ocp.constraints, stage.margins.numel()
    c.lh, c.uh = np.zeros(count), np.full(count, _FAR)
    c.idxbu, c.lbu, c.ubu = np.arange(len(stage.lower)), stage.lower, np.minimum(stage.upper, _FAR)
    c.idxbx, c.lbx, c.ubx = np.array([3, 4]), *stage.speeds
    c.x0 = np.zeros(len(stage.speeds[0]) + 3)
