#!/usr/bin/env python3
"""The controller's problem as C code, and random instances of it with the solutions of CasADi's Ipopt.

usage: make_instances.py --config FOLDER --code FILE.c --instances FILE.txt

Written for ipopt_judge_test.cpp, which solves the same instances with another build of Ipopt. The text file holds
`option NAME VALUE` lines (of both sides), then `size NX NP NG FIRST_INPUT COUNT`, then for each instance one line each
of p, lbx, ubx, lbg, ubg, x0, and the solution: cost and first input (dv/dt, domega/dt).
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import yaml
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, clearance
from seater_common.params import load
from seater_common.separation import convex_outline
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.formulations import make_problem
from seater_nmpc.ocp.problem import Problem
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.programme import ProblemData

Array = NDArray[np.float64]

SEED, COUNT = 20240, 100
OBSTACLE_EVERY = 3  # every third instance has an obstacle beside the way
# From a standing chair to the point that both sides begin at: short of the solution, so that the judge has way to go.
COLD: dict[str, float | int | str] = {"tol": 1e-2, "mu_target": 1e-3, "max_iter": 3000}
# From there on: its barrier and little push away from the bounds, else they leave the valley that they are in.
FINE: dict[str, float | int | str] = {
    "tol": 1e-10,
    "acceptable_iter": 0,  # nothing less than the tolerance counts
    "max_iter": 3000,
    "mu_init": 1e-3,
    "bound_push": 1e-4,
    "bound_frac": 1e-4,
    "slack_bound_push": 1e-4,
    "slack_bound_frac": 1e-4,
    "honor_original_bounds": "yes",  # the default of 3.11.9, not that of 3.14
    "mu_strategy": "monotone",
    "linear_solver": "mumps",
}


def write_code(problem: Problem, path: Path) -> None:
    """f, its gradient, g, its Jacobian and the lower triangle of the Lagrangian's Hessian, as C functions."""
    x, p, f, g = (problem.functions[key] for key in ("x", "p", "f", "g"))
    lam_f, lam_g = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", g.numel())
    hessian = ca.tril(ca.hessian(lam_f * f + ca.dot(lam_g, g), x)[0])
    generator = ca.CodeGenerator(path.name, {"with_header": True})
    for name, inputs, value in (
        ("judge_f", [x, p], f),
        ("judge_grad_f", [x, p], ca.densify(ca.gradient(f, x))),
        ("judge_g", [x, p], ca.densify(g)),
        ("judge_jac_g", [x, p], ca.jacobian(g, x)),
        ("judge_hess_l", [x, p, lam_f, lam_g], hessian),
    ):
        generator.add(ca.Function(name, inputs, [value]))
    generator.generate(f"{path.parent}/")


def nlpsol(problem: Problem, options: dict[str, float | int | str]) -> ca.Function:
    """CasADi's Ipopt; an unsolved instance is an error, since none may be dropped."""
    quiet = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "error_on_fail": True}
    given = {f"ipopt.{name}": value for name, value in options.items()}
    return ca.nlpsol("judge", "ipopt", problem.functions, quiet | given)


def solve(solver: ca.Function, data: ProblemData, start: Array) -> tuple[Array, float]:
    """The variables and the cost of the solution."""
    result = solver(x0=start, p=data.p, lbx=data.lbx, ubx=data.ubx, lbg=data.lbg, ubg=data.ubg)
    return result["x"].full().ravel(), float(result["f"])


def random_state(rng: np.random.Generator, chair: Chair, dock: Dock) -> Array:
    """(x, y, theta, v, omega), the dock ahead within 0.4 rad, the chair clear of the walls."""
    while True:
        x, y = rng.uniform(-3.0, -0.8), rng.uniform(-1.0, 1.0)
        heading = math.atan2(-y, -x) + rng.uniform(-0.4, 0.4)
        if clearance(chair, dock.bay, [x, y, heading]) > 0.0:
            return np.array([x, y, heading, rng.uniform(0.0, 0.4), rng.uniform(-0.3, 0.3)])


def random_obstacle(rng: np.random.Generator, state: Array) -> Array:
    """A polygon of up to six corners within 0.2 m, beside the straight way to the dock."""
    x, y = state[:2] * rng.uniform(0.4, 0.8)
    centre = [x, y + rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 0.9)]
    angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, 3)) + np.array([0.0, 0.1, 0.2])
    angles = np.concatenate([angles, angles + math.pi])
    return convex_outline(centre + rng.uniform(0.1, 0.2) * np.column_stack([np.cos(angles), np.sin(angles)]))


def instances(problem: Problem, chair: Chair, dock: Dock, horizon: int) -> Iterator[tuple[ProblemData, Array]]:
    """Data and the common starting point of each instance."""
    rng, areas, solver = np.random.default_rng(SEED), dock_areas(dock), nlpsol(problem, COLD)
    for i in range(COUNT):
        state = random_state(rng, chair, dock)
        standing = np.repeat(state[None, :], horizon + 1, axis=0) * [1.0, 1.0, 1.0, 0.0, 0.0]
        data = problem.data(state, areas)
        x, _ = solve(solver, data, problem.guess(standing, areas))
        if i % OBSTACLE_EVERY == 0:
            lines = problem.obstacle_lines([random_obstacle(rng, state)], problem.states(x))
            data = problem.data(state, areas, lines)
            x, _ = solve(solver, data, x)
        yield data, x


def main() -> None:
    """Program entry."""
    parser = argparse.ArgumentParser(description="C code and solved random instances of the controller's problem.")
    for name, text in (("config", "folder of the YAML files"), ("code", "C file"), ("instances", "text file")):
        parser.add_argument(f"--{name}", type=Path, required=True, help=text)
    arguments = parser.parse_args()

    chair = load(Chair, yaml.safe_load((arguments.config / "chair.yaml").read_text()), "chair")
    dock = load(Dock, yaml.safe_load((arguments.config / "docks" / "default.yaml").read_text()), "dock")
    values = yaml.safe_load((arguments.config / "controller.yaml").read_text())
    parameters = load(NmpcParameters, values, "controller").control
    if parameters.formulation != "docking" or not parameters.walls:
        raise ValueError("controller.yaml: the judge is about the formulation docking with walls")
    problem = make_problem(chair, parameters, dock_areas(dock))
    write_code(problem, arguments.code)

    first = 5  # the variables begin with z0 (5,), u0 (2,)
    solver = nlpsol(problem, FINE)
    sizes = [problem.functions[key].numel() for key in ("x", "p", "g")]
    lines = [f"option {name} {value}" for name, value in FINE.items()]
    lines.append(" ".join(map(str, ["size", *sizes, first, COUNT])))
    for data, start in instances(problem, chair, dock, parameters.horizon):
        x, cost = solve(solver, data, start)
        rows = [data.p, data.lbx, data.ubx, data.lbg, data.ubg, start, np.array([cost, *x[first : first + 2]])]
        lines += [" ".join(f"{value:.17g}" for value in row) for row in rows]
    arguments.instances.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
