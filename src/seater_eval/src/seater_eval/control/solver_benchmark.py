"""Every solver and baseline in a closed loop into the bay: what a control cycle costs, and how that grows with the
horizon."""

from __future__ import annotations

import gc
import math
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.do_mpc_baseline import DoMpc
from seater_eval.baselines.interface import PoseController
from seater_eval.baselines.nmpc import Nmpc, available_solvers, for_perfect_chair
from seater_eval.baselines.paper_formulation import PaperFormulation
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs
from seater_eval.baselines.trajectories import Trajectory, quickest
from seater_eval.control.acados_comparison import MORE_STARTS, compare_with_acados
from seater_eval.report.bars import Bar
from seater_eval.report.statistics import spread
from seater_eval.run.progress import progress_bar
from seater_eval.run.setup_files import Setup, load_setup

IPOPT_DEFAULT = "ipopt_default"
WANTED = ("rti", "fatrop", "ipopt", IPOPT_DEFAULT, "do_mpc")  # the same problem
OTHERS = ("paper_formulation", "park_kuipers", "pbvs")  # another problem, or none; at the bar's horizon only
SLOW = (IPOPT_DEFAULT,)  # tens of milliseconds a cycle
HORIZONS, QUICK_HORIZONS = (10, 20, 30, 40, 60, 80), (20, 30, 80)
BAR_HORIZON, GROWTH = 30, (20, 80)
STARTS = ((-2.5, 0.8, -0.35), (-3.0, -0.6, 0.1), (-2.0, 0.4, 0.2), (-3.5, 1.2, -0.6), (-1.8, -0.3, 0.0))
OBSTACLES = tuple(  # beside the way, so that their lines are part of what is solved [m]
    np.array([[-1.3, low], [-1.0, low], [-1.0, low + 0.3], [-1.3, low + 0.3]]) for low in (-1.3, 1.0)
)
ARRIVED = 0.003  # [m] the loop ends here: what is timed is driving, not standing


def missing_solvers() -> list[str]:
    """What is wanted but not in seater_nmpc's registry."""
    return [name for name in WANTED if name != "do_mpc" and name not in available_solvers()]


def run_benchmark(config: str | Path, quick: bool) -> dict[str, Any]:
    """One after another in this process, so that nothing of our own disturbs the timing; methods take turns."""
    setup = load_setup(config)
    horizons = QUICK_HORIZONS if quick else HORIZONS
    # Few cycles have a 99th percentile that one interruption decides: each is driven several times then.
    starts, longest, repeats = (STARTS[:1], 6.0, 4) if quick else (STARTS, 15.0, 1)
    cases = _cases(horizons, quick)
    made = {case: make_controller(case[1], setup, case[0]) for case in cases}
    runs: dict[tuple[int, str], list[Trajectory]] = {case: [] for case in cases}
    total = sum(len(starts[: _starts_of(case)]) * _turns_of(case, repeats) for case in cases)
    with progress_bar("solver_benchmark", total) as progress:
        for number, start in enumerate(starts):
            of_start: dict[tuple[int, str], list[Trajectory]] = {c: [] for c in cases if number < _starts_of(c)}
            for turn in range(repeats):
                for case in of_start:
                    if turn < _turns_of(case, repeats):
                        of_start[case].append(timed_run(made[case], setup, start, longest, free=case[1] in OTHERS))
                        progress.update()
            for case, again in of_start.items():
                runs[case].append(quickest(again))
    rows = [_row(case, runs[case]) for case in cases]
    return {
        "quick": quick,
        "conditions": {
            "loop": "perfect unicycle, exact arc, perfect state; from rest to 3 mm from the dock or the end",
            "starts": starts,
            "longest_s": longest,
            "repeats": f"{repeats} of each loop (slow solvers: at most 2), each cycle at the shortest of its times",
            "problem": "config/controller.yaml: walls, bay speed, view, two obstacles (do_mpc: walls); no lag",
            "times_are": "called from Python: solver and whole cycle, wall time and processor time (cpu) of the thread",
            "bars_are_of": "the solver's processor time, which other load on the machine does not change",
            "cores": os.cpu_count(),
            "load_average": os.getloadavg(),
        },
        "available_solvers": available_solvers(),
        "missing_solvers": missing_solvers(),
        "rows": rows,
    }


def run_acados(config: str | Path, folder: Path, quick: bool) -> dict[str, Any]:
    """The whole control cycle beside acados, from more starts. Raises AcadosError: none there that works."""
    starts = STARTS[:1] if quick else STARTS + MORE_STARTS
    return compare_with_acados(load_setup(config), folder, starts, OBSTACLES, BAR_HORIZON, quick)


def _cases(horizons: Sequence[int], quick: bool) -> list[tuple[int, str]]:
    """(horizon, method); with `quick` only what the bars need, and what costs nothing."""
    names = [name for name in WANTED if name not in missing_solvers()]
    cases = [(N, name) for N in horizons for name in names if not quick or name == "rti" or N == BAR_HORIZON]
    cases += [(BAR_HORIZON, name) for name in OTHERS]
    # What is compared with each other runs one after the other: the machine's speed drifts within some seconds.
    cases.sort(key=lambda case: case[1] != "rti")
    return [case for case in cases if not (quick and case[1] in ("ipopt", "do_mpc", "paper_formulation"))]


def _starts_of(case: tuple[int, str]) -> int:
    """From how many of the starts a method is run: all where a bar looks, fewer where only the growth is shown."""
    return len(STARTS) if case[0] == BAR_HORIZON or case[1] == "rti" else 1


def _turns_of(case: tuple[int, str], repeats: int) -> int:
    """How often a loop is driven: an interruption is short beside the cycles of a slow solver."""
    return min(repeats, 2) if case[1] in SLOW else repeats


def make_controller(name: str, setup: Setup, horizon: int) -> PoseController:
    """By the name in the table. The same problem for all of WANTED."""
    parameters = replace(for_perfect_chair(setup.parameters.control), horizon=horizon)
    if name == "do_mpc":
        return DoMpc(setup.chair, setup.dock, parameters)
    if name == "paper_formulation":
        return PaperFormulation(setup.chair, parameters)
    if name == "park_kuipers":
        return ParkKuipers(setup.chair.limits)
    if name == "pbvs":
        return Pbvs(setup.chair.limits)
    nmpc = Nmpc(setup.chair, setup.dock, parameters, name)
    nmpc.controller.set_obstacles(OBSTACLES)
    return nmpc


def timed_run(
    controller: PoseController, setup: Setup, start: tuple[float, float, float], longest: float, free: bool
) -> Trajectory:
    """One closed loop without Python's garbage collector in between."""

    def arrived(pose: NDArray[np.float64], speed: tuple[float, float]) -> bool:
        return math.hypot(pose[0], pose[1]) < ARRIVED

    gc.collect()
    gc.disable()
    try:
        return run_perfect(controller, setup.chair.limits, start, longest, accelerations=not free, until=arrived)
    finally:
        gc.enable()


def _row(case: tuple[int, str], runs: list[Trajectory]) -> dict[str, Any]:
    N, name = case
    solve = np.concatenate([1e3 * (run.solve_times if np.any(run.solve_times) else run.cycle_times) for run in runs])
    solve_cpu = np.concatenate([1e3 * (run.solve_cpu if np.any(run.solve_cpu) else run.cycle_cpu) for run in runs])
    return {
        "solver": name,
        "horizon": N,
        "cycles": len(solve),
        "solve_ms": spread(solve),
        "solve_cpu_ms": spread(solve_cpu),
        "cycle_ms": spread(np.concatenate([1e3 * run.cycle_times for run in runs])),
        "cycle_cpu_ms": spread(np.concatenate([1e3 * run.cycle_cpu for run in runs])),
        "cold_ms": spread([1e3 * float(run.solve_times[0]) for run in runs]),
        "failures": sum(run.failures for run in runs),
        "final_error_mm": 1e3 * max(run.final_position_error for run in runs),
    }


def _value(data: dict[str, Any], name: str, horizon: int, statistic: str) -> float | None:
    for row in data["rows"]:
        if row["solver"] == name and row["horizon"] == horizon:
            return row["solve_cpu_ms"][statistic]
    return None


def benchmark_bars(data: dict[str, Any]) -> list[Bar]:
    """Ratios within this run. A solver that is not there leaves its bars unmet."""
    ours, N = _value(data, "rti", BAR_HORIZON, "p99"), BAR_HORIZON
    absent = ", ".join(data["missing_solvers"])
    note = f"not available: {absent}; available: {', '.join(data['available_solvers'])}" if absent else ""

    def ratio(other: float | None, value: float | None) -> float | None:
        return None if other is None or value is None else other / value

    default, fatrop = _value(data, IPOPT_DEFAULT, N, "p99"), _value(data, "fatrop", N, "p99")
    growth = ratio(_value(data, "rti", GROWTH[1], "median"), _value(data, "rti", GROWTH[0], "median"))
    return [
        Bar(f"p99 of Ipopt's defaults / p99 of rti, N = {N}", ratio(default, ours), 15.0, "", "at least", note),
        Bar(f"p99 of fatrop / p99 of rti, N = {N}", ratio(fatrop, ours), 3.0, "", "at least", note),
        Bar(f"growth of rti, N = {GROWTH[1]} / N = {GROWTH[0]}", growth, 4.4, "", "at most", note),
    ]
