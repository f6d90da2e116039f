"""Table II of the paper (design, section 5): its results, its formulation reproduced here, and seater's controller."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.geometry import Chair, Dock
from seater_eval.baselines.closed_loop import euler_step, run_perfect
from seater_eval.baselines.interface import PoseController
from seater_eval.baselines.minimum_time import MinimumTime
from seater_eval.baselines.nmpc import Nmpc, for_perfect_chair
from seater_eval.baselines.paper_formulation import PaperFormulation
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs
from seater_eval.baselines.trajectories import Trajectory
from seater_eval.report.bars import Bar
from seater_eval.report.evaluation_style import COLOURS, figure, save
from seater_eval.report.tables import text_table
from seater_eval.run.parallel import run_jobs
from seater_eval.run.setup_files import load_setup
from seater_nmpc.parameters import ControlParameters, weight_set

# Initial pose (x [m], y [m], heading [deg]) -> published final error (position [m], heading [deg]).
TABLE_II = {
    (-1.5, 2.0, 90.0): (0.00281839, 0.00045076),
    (1.5, 2.0, -90.0): (0.00282463, 0.00071455),
    (1.5, 2.0, 0.0): (0.00144737, 0.00015409),
    (-1.5, 2.0, 0.0): (0.00143895, 0.00020460),
}
METHODS = ("paper_formulation", "park_kuipers", "pbvs", "seater_calm", "seater")
DURATION = 12.0  # [s] simulated
POSITION_LIMIT, HEADING_LIMIT = 1e-5, 1e-4  # [m], [deg]


@dataclass(frozen=True)
class TableJob:
    """One run."""

    config: str
    method: str
    pose: tuple[float, float, float]
    max_iterations: int | None  # of the paper's formulation; None: Ipopt's default


def paper_chair(chair: Chair) -> Chair:
    """The chair with the forward speed limit both ways: two of the paper's poses lie ahead of its dock, and its errors
    are those of mirror images, so its vehicle drives backward as well as forward."""
    return replace(chair, limits=replace(chair.limits, v_reverse_max=chair.limits.v_max))


def run_table_job(job: TableJob) -> dict[str, Any]:
    """The paper's model (Euler step of one control period), perfect state, free space, 12 s."""
    setup = load_setup(job.config)
    chair = paper_chair(setup.chair)
    start = [job.pose[0], job.pose[1], math.radians(job.pose[2])]
    if job.method == "minimum_time":
        solution = MinimumTime(chair, None).solve(start)
        return {"method": job.method, "pose": job.pose, "time_s": None if solution is None else solution.time}
    accelerations = job.method != "paper_formulation"  # the paper's problem has none
    controller = _controller(job, chair, setup.dock, setup.parameters.control)
    run = run_perfect(controller, chair.limits, start, DURATION, model=euler_step, accelerations=accelerations)
    return _run_values(job, run)


def _controller(job: TableJob, chair: Chair, dock: Dock, parameters: ControlParameters) -> PoseController:
    if job.method == "paper_formulation":
        return PaperFormulation(chair, None, job.max_iterations)
    if job.method == "park_kuipers":
        return ParkKuipers(chair.limits)
    if job.method == "pbvs":
        return Pbvs(chair.limits)
    free = replace(for_perfect_chair(parameters), formulation="docking", integrator="euler", walls=False)
    if (
        job.method == "seater"
    ):  # for a perfectly known state; seater_calm is what config/controller.yaml has, made for noise
        free = replace(free, weights=weight_set("fast"), fine_steps=free.horizon // 2)
    return Nmpc(chair, dock, free)


def _run_values(job: TableJob, run: Trajectory) -> dict[str, Any]:
    position = np.hypot(run.poses[:, 0], run.poses[:, 1])
    heading = np.degrees(np.abs(run.poses[:, 2]))
    reached = np.flatnonzero((position > POSITION_LIMIT) | (heading > HEADING_LIMIT))
    exact = reached[-1] + 1 if len(reached) else 0
    return {
        "method": job.method,
        "pose": job.pose,
        "position_error_m": run.final_position_error,
        "heading_error_deg": math.degrees(run.final_heading_error),
        "time_to_bar_s": float(run.times[exact]) if exact < len(run.times) else None,
        "solve_median_ms": 1e3 * float(np.median(run.solve_times)),
        "solve_max_ms": 1e3 * float(np.max(run.solve_times)),
        "failures": run.failures,
        "times": run.times[::2],
        "position": position[::2],
        "heading": heading[::2],
        "path": run.poses[::2, :2],
    }


def run_table(config: str | Path, quick: bool) -> dict[str, Any]:
    """All methods from all four poses."""
    iterations = 50 if quick else None
    slow_first = sorted([*METHODS, "minimum_time"], key=lambda method: method != "paper_formulation")
    jobs = [TableJob(str(config), method, pose, iterations) for method in slow_first for pose in TABLE_II]
    runs = run_jobs(run_table_job, jobs, label="docking_table")
    rows = {method: [run for run in runs if run["method"] == method] for method in [*METHODS, "minimum_time"]}
    published = [
        {"pose": pose, "position_error_m": error[0], "heading_error_deg": error[1]} for pose, error in TABLE_II.items()
    ]
    conditions = {
        "model": "the paper's Euler step, dt = control period; perfect state; no areas",
        "duration_s": DURATION,
        "limits": "of chair.yaml, v_max both ways; the paper's: no acceleration limits, N = 20, dt = 0.1 s",
        "ipopt_iterations_of_the_paper": iterations or "default (3000)",
    }
    return {"quick": quick, "conditions": conditions, "published": published, "runs": rows}


def table_bars(data: dict[str, Any]) -> list[Bar]:
    """The worst of the four poses after 12 s."""
    ours = data["runs"]["seater"]
    position = max(run["position_error_m"] for run in ours)
    heading = max(run["heading_error_deg"] for run in ours)
    return [
        Bar("Table II, ours, worst position error", 1e3 * position, 1e3 * POSITION_LIMIT, "mm"),
        Bar("Table II, ours, worst heading error", heading, HEADING_LIMIT, "deg"),
    ]


def describe_table(data: dict[str, Any]) -> str:
    """One line for each pose and method."""
    head = ["initial pose", "method", "error [mm]", "heading [deg]", "at the bar after", "solve median", "max"]
    rows = []
    for i, published in enumerate(data["published"]):
        x, y, heading = published["pose"]
        rows.append([f"({x:.1f}, {y:.1f}, {heading:.0f} deg)", "paper (published)", *_errors(published), "", "", ""])
        for method in METHODS:
            run = data["runs"][method][i]
            reached = "-" if run["time_to_bar_s"] is None else f"{run['time_to_bar_s']:.2f} s"
            times = [f"{run[key]:.1f} ms" for key in ("solve_median_ms", "solve_max_ms")]
            rows.append(["", method, *_errors(run), reached, *times])
        bound = data["runs"]["minimum_time"][i]["time_s"]
        rows.append(["", "minimum time, rest to rest", "0", "0", "-" if bound is None else f"{bound:.2f} s", "", ""])
    return text_table(head, rows)


def _errors(run: dict[str, Any]) -> list[str]:
    return [f"{1e3 * run['position_error_m']:.6f}", f"{run['heading_error_deg']:.6f}"]


def draw_table(data: dict[str, Any], path: Path) -> Path:
    """Error over time from each pose, and the paths."""
    fig, axes = figure(4, 2, width=4.6, height=4.2)
    for i, published in enumerate(data["published"]):
        x, y, heading = published["pose"]
        axes[0, i].set_title(f"from ({x:.1f} m, {y:.1f} m, {heading:.0f}°)")
        for method in METHODS:
            run = data["runs"][method][i]
            route = np.asarray(run["path"])
            axes[0, i].plot(route[:, 0], route[:, 1], color=COLOURS[method], label=method)
            axes[1, i].semilogy(run["times"], 1e3 * np.maximum(run["position"], 1e-9), color=COLOURS[method])
        axes[1, i].axhline(1e3 * POSITION_LIMIT, color="black", ls="--", lw=0.8)
        axes[1, i].axhline(1e3 * published["position_error_m"], color="black", ls=":", lw=0.8)
        axes[1, i].set(xlabel="time [s]", ylim=(1e-6, 5e3))
        axes[0, i].plot(0.0, 0.0, "k+", ms=12)
        axes[0, i].set(aspect="equal", xlabel="x [m]")
        axes[0, i].grid(alpha=0.3)
        axes[1, i].grid(alpha=0.3)
    axes[0, 0].legend(fontsize=8)
    axes[0, 0].set_ylabel("y [m]")
    axes[1, 0].set_ylabel("distance from the dock [mm]  (-- bar, ·· paper)")
    fig.suptitle("Table II: the paper's model, perfect state, free space")
    return save(fig, path)
