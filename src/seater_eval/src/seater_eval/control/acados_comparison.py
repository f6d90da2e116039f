"""The whole control cycle beside acados on the same instances, in turns; optional, where acados is installed."""

from __future__ import annotations

import gc
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import arc_step
from seater_eval.acados.driver import AcadosDriver
from seater_eval.acados.peer import AcadosPeer
from seater_eval.acados.recording_solver import RecordingSolver
from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.nmpc import for_perfect_chair
from seater_eval.report.bars import Bar
from seater_eval.report.statistics import spread
from seater_eval.run.progress import progress_bar
from seater_eval.run.setup_files import Setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.ocp.areas import dock_areas
from seater_nmpc.ocp.docking_problem import DockingProblem
from seater_nmpc.programme import ProblemData
from seater_nmpc.solve.interface import outside

Array = NDArray[np.float64]
Start = tuple[float, float, float]

# With the benchmark's own five starts some 2200 cycles.
MORE_STARTS: tuple[Start, ...] = (
    (-2.2, -0.7, 0.3),
    (-2.8, 0.2, 0.0),
    (-3.2, 0.9, -0.3),
    (-2.6, -1.0, 0.4),
    (-1.6, 0.2, -0.1),
)
REPEATS, QUICK_REPEATS = 3, 2  # of each loop; each cycle counts at the shortest of its times
_LONGEST, _ARRIVED = 15.0, 0.003  # [s], [m] a loop ends there, as the benchmark's
_COLUMNS = 8  # of what is noted of a cycle: wall [s], cpu [s], violation, cost; each ours and acados'


def compare_with_acados(
    setup: Setup, folder: Path, starts: Sequence[Start], obstacles: Sequence[Array], horizon: int, quick: bool
) -> dict[str, Any]:
    """Both on each cycle's instance, the chair driven by ours; then acados drives from the same starts by itself.

    Timed are the whole `command()`, and of acados: setting the instance, one step and reading the plan; each by its own
    process. The same lines separate from obstacles, so acados' time is without finding them. Raises AcadosError.
    """
    parameters = replace(for_perfect_chair(setup.parameters.control), horizon=horizon)
    problem = DockingProblem(setup.chair, parameters, dock_areas(setup.dock))
    solver, repeats = RecordingSolver.for_problem(problem, parameters), QUICK_REPEATS if quick else REPEATS
    ours = DockingController(setup.chair, setup.dock, parameters, deterministic=True, solver=solver)
    ours.set_obstacles(obstacles)
    ours.warm_up()
    judge, rows, own, ends = _Judge(problem), [], [], []
    with (
        AcadosPeer(setup.chair, setup.dock, parameters, folder) as peer,
        progress_bar("acados", len(starts) * (repeats + 1)) as progress,
    ):
        driver = AcadosDriver(setup.chair, setup.dock, parameters, peer, ours.obstacles)
        for start in starts:
            again = []
            for _ in range(repeats):
                table, error = _drive(ours, solver, peer, judge, start)
                again.append(table)
                progress.update()
            if len({len(table) for table in again}) != 1:
                raise ValueError("repeated runs differ: their cycles cannot be compared")
            least = again[0].copy()
            least[:, :4] = np.min([table[:, :4] for table in again], axis=0)
            rows.append(least)
            ends.append(error)
            own.append(run_perfect(driver, setup.chair.limits, start, _LONGEST, until=_arrived))
            progress.update()
    notes = np.vstack(rows)
    return {
        "horizon": horizon,
        "cycles": len(notes),
        "starts": list(starts),
        "repeats": repeats,
        "wall_ms": _pair(1e3 * notes[:, 0:2]),
        "cpu_ms": _pair(1e3 * notes[:, 2:4]),
        "violation": _pair(notes[:, 4:6]),
        "cost_above_ours": spread((notes[:, 7] - notes[:, 6]).tolist()),
        "cost_of_ours": spread(notes[:, 6].tolist()),
        "final_error_mm": {"command": 1e3 * max(ends), "acados": 1e3 * max(run.final_position_error for run in own)},
        "seconds_driven": {
            "command": parameters.control_period * len(notes),
            "acados": sum(float(run.times[-1]) for run in own),
        },
        "failures_of_acados": sum(run.failures for run in own),
    }


def acados_bars(data: dict[str, Any]) -> list[Bar]:
    """Ratios of processor times within this run."""
    cpu, N = data["cpu_ms"], data["horizon"]
    ratio = {level: cpu["command"][level] / cpu["acados"][level] for level in ("median", "p99")}
    return [
        Bar(f"p99 of the whole command() / p99 of acados' step, N = {N}", ratio["p99"], 1.0, "", "at most", ""),
        Bar(f"the same, medians, N = {N}", ratio["median"], 1.3, "", "at most", ""),
    ]


def describe_acados(data: dict[str, Any]) -> str:
    """A few lines for a person."""
    lines = [f"  acados on the same {data['cycles']} instances, N = {data['horizon']}; median, p99, max:"]
    for key, what in (("cpu_ms", "processor time [ms]"), ("wall_ms", "wall time [ms]"), ("violation", "violation")):
        for name in ("command", "acados"):
            values = [data[key][name][level] for level in ("median", "p99", "max")]
            lines.append(f"    {what:20} {name:8} " + "  ".join(f"{value:.3g}" for value in values))
    above, end = data["cost_above_ours"], data["final_error_mm"]
    lines.append(f"    cost of acados' plans above ours: median {above['median']:.2g}, p99 {above['p99']:.2g}")
    lines.append(f"    final error, each driving: command {end['command']:.2f} mm, acados {end['acados']:.2f} mm")
    return "\n".join(lines)


class _Judge:
    """Cost and largest violation of variables by seater_nmpc's own functions."""

    def __init__(self, problem: DockingProblem) -> None:
        x, p, f, g = (problem.functions[key] for key in ("x", "p", "f", "g"))
        self._functions = ca.Function("judge", [x, p], [f, g])

    def __call__(self, x: Array, data: ProblemData) -> tuple[float, float]:
        f, g = (value.full().ravel() for value in self._functions(x, data.p))
        return float(f[0]), max(outside(x, data.lbx, data.ubx), outside(g, data.lbg, data.ubg))


def _drive(
    ours: DockingController, solver: RecordingSolver, peer: AcadosPeer, judge: _Judge, start: Start
) -> tuple[Array, float]:
    """One closed loop driven by ours: a row a warm cycle (see _COLUMNS), and the final error [m]."""
    ours.reset()
    pose, speed, period, rows = np.array(start), (0.0, 0.0), ours.parameters.control_period, []
    gc.collect()
    gc.disable()
    try:
        for _ in range(round(_LONGEST / period)):
            wall, cpu = time.perf_counter(), time.thread_time()
            command = ours.command(pose, speed, (0.0, 0.0, 0.0))
            cpu, wall = time.thread_time() - cpu, time.perf_counter() - wall
            if solver.cold:
                peer.begin(solver.solution.x)
            else:
                x, answer = peer.step(solver.data)
                own, theirs = judge(solver.solution.x, solver.data), judge(x, solver.data)
                rows.append([wall, answer.wall, cpu, answer.cpu, own[1], theirs[1], own[0], theirs[0]])
            speed = (command.v, command.omega)
            pose = arc_step(pose, *speed, period)
            if _arrived(pose, speed):
                break
    finally:
        gc.enable()
    return np.array(rows).reshape(-1, _COLUMNS), float(np.hypot(pose[0], pose[1]))


def _arrived(pose: Array, speed: tuple[float, float]) -> bool:
    return float(np.hypot(pose[0], pose[1])) < _ARRIVED


def _pair(columns: Array) -> dict[str, Any]:
    return {name: spread(columns[:, i].tolist()) for i, name in enumerate(("command", "acados"))}
