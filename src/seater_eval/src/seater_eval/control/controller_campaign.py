"""Many dockings from random starts, on all cores: success, accuracy, time against the minimum, clearance, limits, view."""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.geometry import Chair, Dock, clearance, polygon_distance
from seater_common.se2 import wrap_angle
from seater_eval.baselines.bay_speed import SlowInBay
from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.interface import PoseController
from seater_eval.baselines.minimum_time import MinimumTime, straight_line_bound
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs
from seater_eval.baselines.trajectories import Array
from seater_eval.control.campaign_run import Case, DockingRun, draw_start, figures
from seater_eval.control.pose_noise import DockSensor, NoiseModel
from seater_eval.report.bars import Bar
from seater_eval.report.statistics import spread
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import job_seed
from seater_eval.run.setup_files import Setup, load_setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.plan.navigator import Navigator

OUT_OF_VIEW = 0.5  # [s] longest time without a marker in view
_KEEP_EVERY = 10  # rows of the trajectory between two points of the image


@dataclass(frozen=True)
class CampaignJob:
    """One case and how to run it."""

    config: str
    case: Case
    solver: str  # empty: that of config/controller.yaml
    noise: NoiseModel


@functools.lru_cache(maxsize=2)
def _tools(config: str, solver: str) -> tuple[Setup, DockingController, Navigator, MinimumTime]:
    """Made once in each process. No wall-time limit: a loaded machine decides the same."""
    setup = load_setup(config)
    if solver:
        control = dataclasses.replace(setup.parameters.control, solver=solver)
        setup = dataclasses.replace(setup, parameters=dataclasses.replace(setup.parameters, control=control))
    controller = DockingController(setup.chair, setup.dock, setup.parameters.control, deterministic=True)
    controller.warm_up()
    navigator = Navigator(setup.chair, setup.dock, setup.parameters.control, setup.parameters.planner)
    return setup, controller, navigator, MinimumTime(setup.chair, setup.dock, setup.dock.tolerance)


def run_campaign_job(job: CampaignJob) -> dict[str, Any]:
    """The docking, the bound for its time, and the feedback laws from the same start."""
    setup, controller, navigator, minimum = _tools(job.config, job.solver)
    run = DockingRun(setup, job.case, controller, job.noise, navigator)
    trajectory = run.run()
    result = figures(run, trajectory, job.case)
    bound = minimum.solve(job.case.start)
    result["minimum_time_s"] = None if bound is None else bound.time
    result["minimum_time_guesses_agreeing"] = 0 if bound is None else bound.agreeing
    result["certain_bound_s"] = straight_line_bound(setup.chair.limits, job.case.start, setup.dock.tolerance)
    for law in (ParkKuipers(setup.chair.limits), Pbvs(setup.chair.limits)):
        result[law.name] = _feedback(setup, law, job.case)
    result["path"] = np.round(trajectory.poses[::_KEEP_EVERY], 4)
    return result


def _feedback(setup: Setup, law: PoseController, case: Case) -> dict[str, Any]:
    """A feedback law with a perfect chair and perfect state, slowed down in the bay, whose walls it does not know."""
    run = run_perfect(SlowInBay(law, setup.chair, setup.dock), setup.chair.limits, case.start, 40.0)
    obstacles = [np.array(outline).reshape(-1, 2) for outline in case.obstacles]
    nearest = _smallest_clearance(setup.chair, setup.dock, run.poses[::2], obstacles)
    time = run.docking_time(setup.dock.tolerance)
    return {"docking_time_s": time, "min_clearance_m": nearest, "docked": time is not None and nearest > 0.0}


def _smallest_clearance(chair: Chair, dock: Dock, poses: Array, obstacles: list[Array]) -> float:
    """Over the poses (n, 3) of a way [m]. A pose is skipped when the chair cannot have come nearer than the smallest so far:
    no point of it moves farther than the axle's way plus the turn times its distance from there."""
    reach = float(np.max(np.linalg.norm(chair.corners(), axis=1)))
    smallest, at_least = math.inf, -math.inf
    before = poses[0]
    for pose in poses:
        at_least -= math.hypot(*(pose[:2] - before[:2])) + abs(wrap_angle(pose[2] - before[2])) * reach
        before = pose
        if at_least < smallest:
            at_least = _clearance(chair, dock, pose, obstacles)
            smallest = min(smallest, at_least)
    return smallest


def _clearance(chair: Chair, dock: Dock, pose: Array, obstacles: list[Array]) -> float:
    corners = chair.corners_at(pose)
    return min([clearance(chair, dock.bay, pose), *(polygon_distance(corners, outline) for outline in obstacles)])


def draw_cases(setup: Setup, runs: int, seed: int, noise: NoiseModel, obstacles: bool) -> list[Case]:
    """The same for the same seed, whatever `runs` is beyond them."""
    sensor = DockSensor(setup.chair, setup.dock, setup.camera, noise)
    cases = []
    for index in range(runs):
        rng = np.random.default_rng([seed, index])
        start = draw_start(
            setup.chair, setup.dock, sensor, lambda pose: clearance(setup.chair, setup.dock.bay, pose), rng
        )
        outlines = _draw_obstacles(setup, start, rng) if obstacles else ()
        cases.append(Case(index, start, job_seed(seed, index), outlines))
    return cases


def _draw_obstacles(
    setup: Setup, start: tuple[float, float, float], rng: np.random.Generator
) -> tuple[tuple[float, ...], ...]:
    """Up to two convex polygons, clear of the start, of the bay and of the straight way into it."""
    reach, half = setup.dock.predock_x - setup.chair.length_rear - 0.6, 0.5 * setup.dock.bay.width + 0.25
    lane = np.array(
        [[reach, -half], [setup.dock.bay.back_wall_x, -half], [setup.dock.bay.back_wall_x, half], [reach, half]]
    )
    chair, found = setup.chair.corners_at(start), []
    for _ in range(int(rng.integers(0, 3))):
        corners, size = int(rng.integers(3, 7)), rng.uniform(0.1, 0.3)
        turn, middle = rng.uniform(0.0, 2.0 * math.pi), rng.uniform([-3.5, -2.2], [-0.3, 2.2])
        angles = turn + 2.0 * math.pi * np.arange(corners) / corners
        outline = middle + size * np.column_stack([np.cos(angles), np.sin(angles)])
        if polygon_distance(outline, chair) >= 0.4 and polygon_distance(outline, lane) >= 0.05:
            found.append(tuple(float(value) for value in outline.ravel()))
    return tuple(found)


def run_campaign(
    config: str | Path,
    runs: int,
    *,
    seed: int = 1,
    solver: str = "",
    workers: int | None = None,
    noise: NoiseModel | None = None,
    partial: Path | None = None,
) -> dict[str, Any]:
    """All runs, in the order of their index. `partial`: see run_long."""
    setup, noise = load_setup(config), noise or NoiseModel()
    cases = draw_cases(setup, runs, seed, noise, True)
    jobs = [CampaignJob(str(config), case, solver, noise) for case in cases]
    results = run_long(
        run_campaign_job,
        jobs,
        label="controller_campaign",
        files=Path(config).rglob("*.yaml"),
        partial=partial,
        inputs=jobs[:1],  # a campaign with more runs of the same seed begins with the same ones
        workers=workers,
    )
    conditions = {
        "starts": "x -4..-1 m, y +-1.5 m, heading +-60 deg, a marker found from the start, 0.1 m clear of the walls",
        "plant": dataclasses.asdict(setup.simulator.plant),
        "odometry": dataclasses.asdict(setup.simulator.odometry),
        "images": {"rate_hz": setup.simulator.camera.rate, "latency_s": setup.simulator.camera.latency},
        "pose_noise": dataclasses.asdict(noise),
        "obstacles": "up to two random convex polygons, clear of the start, the bay and the lane into it",
        "solver": solver or setup.parameters.control.solver,
        "formulation": setup.parameters.control.formulation,
        "docking_time": "from the goal until the true pose stays within the tolerance",
        "minimum_time": "same limits and walls, to the set from which the tolerance need not be left; obstacles ignored",
    }
    return {"seed": seed, "conditions": conditions, "summary": summarize_runs(results), "runs": results}


def summarize_runs(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The figures over all runs."""
    docked = [run for run in runs if run["docked"]]
    ratios = [
        run["docking_time_s"] / run["minimum_time_s"]
        for run in docked
        if run["docking_time_s"] is not None and run["minimum_time_s"]
    ]
    viewed = [run for run in runs if run["started_in_view"]]
    results = [run["result"] for run in runs]
    summary: dict[str, Any] = {
        "runs": len(runs),
        "docked": len(docked),
        "results": {name: results.count(name) for name in sorted(set(results))},
        "retried": sum(run["retries"] > 0 for run in runs),
        "collided": sum(run["collisions"] > 0 for run in runs),
        "limits_violated": sum(run["limits_violated"] for run in runs),
        "largest_excess": {
            key: max(run[key] for run in runs) for key in ("excess_speed", "excess_bay_speed", "excess_request")
        },
        "started_in_view": len(viewed),
        "out_of_view": sum(run["out_of_view_s"] > OUT_OF_VIEW for run in viewed),
        "out_of_view_s": spread(run["out_of_view_s"] for run in viewed),
        "position_error_mm": spread(1e3 * run["position_error_m"] for run in runs),
        "heading_error_deg": spread(run["heading_error_deg"] for run in runs),
        "docking_time_s": spread(run["docking_time_s"] for run in docked),
        "minimum_time_s": spread(run["minimum_time_s"] for run in runs),
        "time_ratio": spread(ratios),
        "faster_than_the_bound": sum(ratio < 1.0 for ratio in ratios),
        "without_a_bound": sum(run["minimum_time_s"] is None for run in runs),
        "smallest_clearance_mm": 1e3 * min(run["min_clearance_m"] for run in runs),
        "solver_failures": sum(run["solver_failures"] for run in runs),
        "solve_ms": spread(run["solve_ms"] for run in runs),
    }
    for law in ("park_kuipers", "pbvs"):
        summary[law] = _summarize_law(law, runs)
    return summary


def _summarize_law(law: str, runs: list[dict[str, Any]]) -> dict[str, Any]:
    timed = [run for run in runs if run[law]["docked"] and run["minimum_time_s"]]
    return {
        "arrived": sum(run[law]["docking_time_s"] is not None for run in runs),
        "collided": sum(run[law]["min_clearance_m"] <= 0.0 for run in runs),
        "docked": sum(run[law]["docked"] for run in runs),
        "time_ratio": spread(run[law]["docking_time_s"] / run["minimum_time_s"] for run in timed),
    }


def campaign_bars(data: dict[str, Any], quick: bool) -> list[Bar]:
    """Issue 3's. With --quick the counts are of fewer runs, the limits are the same."""
    s = data["summary"]
    note = f"of {s['runs']} runs" if quick else ""
    return [
        Bar("not docked", s["runs"] - s["docked"], 0.0, "runs", note=note),
        Bar("collided", s["collided"], 0.0, "runs", note=note),
        Bar("limits violated", s["limits_violated"], 0.0, "runs", note=note),
        Bar("true position error, 95th percentile", s["position_error_mm"]["p95"], 5.0, "mm"),
        Bar("true heading error, 95th percentile", s["heading_error_deg"]["p95"], 0.5, "deg"),
        Bar("docking time / minimum time, median", s["time_ratio"]["median"], 1.3),
        Bar("markers out of view for more than 0.5 s", s["out_of_view"], 0.0, "runs", note=note),
        Bar("runs", s["runs"], 40 if quick else 1000, "", "at least"),
    ]
