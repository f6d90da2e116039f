#!/usr/bin/env python3
"""Write what the independent judge solves: the problem's functions as C code, and random instances with Python's solutions.

usage: make_instances.py CONFIG_FOLDER OUTPUT_FOLDER. Writes problem.c and instances.txt. The problem is that of the
configuration (walls, bay speed, view, obstacles); its solutions here are those of CasADi's own Ipopt at a tolerance of 1e-10.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import yaml
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.params import load
from seater_nmpc.geometry import dock_areas
from seater_nmpc.nlp import ProblemData, WarmStart
from seater_nmpc.ocp import Problem, make_problem
from seater_nmpc.parameters import IpoptParameters, NmpcParameters
from seater_nmpc.solver import IpoptSolver, SolveStatus

INSTANCES = 100
Array = NDArray[np.float64]


def write_code(problem: Problem, folder: Path) -> None:
    """problem.c: objective, gradient, constraints, jacobian and hessian (lower triangle), all of (x, p)."""
    f = problem.functions
    x, p, sigma, lam = f["x"], f["p"], ca.SX.sym("sigma"), ca.SX.sym("lam", f["g"].numel())
    lagrangian = sigma * f["f"] + ca.dot(lam, f["g"])
    hessian = ca.tril(ca.hessian(lagrangian, x)[0])
    generator = ca.CodeGenerator("problem.c", {"with_header": True})
    for name, inputs, output in (
        ("objective", [x, p], f["f"]),
        ("gradient", [x, p], ca.densify(ca.gradient(f["f"], x))),
        ("constraints", [x, p], ca.densify(f["g"])),
        ("jacobian", [x, p], ca.jacobian(f["g"], x)),
        ("hessian", [x, p, sigma, lam], hessian),
    ):
        generator.add(ca.Function(name, inputs, [output]))
    generator.generate(f"{folder}/")


def draw(problem: Problem, dock: Dock, rng: np.random.Generator) -> tuple[Array, ProblemData, Array]:
    """A state from which the dock is seen, its instance, and a start; every third one has an obstacle beside the way."""
    areas = dock_areas(dock)
    x, y = rng.uniform(-3.0, -1.0), rng.uniform(-1.0, 1.0)
    state = np.array(
        [x, y, np.arctan2(-y, 0.9 - x) + rng.uniform(-0.3, 0.3), rng.uniform(0.0, 0.3), rng.uniform(-0.2, 0.2)]
    )
    states = np.repeat(state[None], problem.states(np.zeros(problem.functions["x"].numel())).shape[0], axis=0)
    polygons = []
    if rng.integers(3) == 0:
        middle = state[:2] + [0.8, -np.copysign(0.9, y)]
        polygons = [middle + 0.15 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])]
    return state, problem.data(state, areas, problem.obstacle_lines(polygons, states)), problem.guess(states, areas)


def solved(problem: Problem, dock: Dock, count: int) -> list[tuple[ProblemData, Array, float, Array]]:
    """(instance, start, cost, first input) of `count` random instances. Both judges start from the same rough solution."""
    rng = np.random.default_rng(7)
    rough = IpoptSolver(problem.functions, IpoptParameters(tolerance=1e-3, max_iterations=500))
    exact = IpoptSolver(problem.functions, IpoptParameters(tolerance=1e-10, max_iterations=1000))
    result = []
    for number in range(count):
        _, data, guess = draw(problem, dock, rng)
        start = rough.solve(data, WarmStart(guess)).x
        solution = exact.solve(data, WarmStart(start))
        if solution.status is not SolveStatus.SOLVED:
            raise RuntimeError(f"instance {number}: {solution.text}")
        u = np.diff(problem.states(solution.x)[:2, 3:], axis=0)[0] / problem.step_lengths[0]
        result.append((data, start, solution.cost, u))
    return result


def main() -> int:
    config, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    chair = load(Chair, yaml.safe_load((config / "chair.yaml").read_text()), "chair")
    dock = load(Dock, yaml.safe_load((config / "docks" / "default.yaml").read_text()), "dock")
    parameters = load(NmpcParameters, yaml.safe_load((config / "controller.yaml").read_text()), "controller").control
    problem = make_problem(chair, replace(parameters, formulation="docking", walls=True), dock_areas(dock))
    write_code(problem, folder)
    instances = solved(problem, dock, INSTANCES)
    data, start, _, u = instances[0]
    first_input = problem.input_columns[0]
    with (folder / "instances.txt").open("w") as out:
        sizes = [len(instances), len(start), len(data.p), len(data.lbg), len(u), *first_input]
        print(*sizes, file=out)
        for data, start, cost, u in instances:
            for values in (data.p, data.lbx, data.ubx, data.lbg, data.ubg, start, [cost], u):
                print(*(repr(float(np.clip(value, -1e19, 1e19))) for value in values), file=out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
