"""Many dockings from random starts, on all cores: success, accuracy, time against the minimum, clearance, limits,
view."""

from __future__ import annotations

import dataclasses
import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.way_clearance import smallest_clearance
from seater_eval.baselines.bay_speed import SlowInBay
from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.interface import PoseController
from seater_eval.baselines.minimum_time import STEPS, MinimumTime, straight_line_bound
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs
from seater_eval.control.campaign_cases import draw_cases
from seater_eval.control.campaign_run import Case, DockingRun, run_values
from seater_eval.control.campaign_summary import summarize_runs
from seater_eval.control.pose_noise import NoiseModel
from seater_eval.run.long_run import run_long
from seater_eval.run.setup_files import Setup, load_setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.parameters import Prediction
from seater_nmpc.plan.navigator import Navigator
from seater_sim.settings import KINEMATIC

_KEEP_EVERY = 10  # rows of the trajectory between two points of the figure


@dataclass(frozen=True)
class CampaignJob:
    """One case and how to run it."""

    config: str
    case: Case
    solver: str  # empty: that of config/controller.yaml
    noise: NoiseModel
    plant: str = ""  # kinematic or wheelchair; empty: that of config/simulator.yaml
    mesh: tuple[int, int] = STEPS  # of the minimum time's motion


@functools.lru_cache(maxsize=2)
def _tools(
    config: str, solver: str, plant: str, mesh: tuple[int, int]
) -> tuple[Setup, DockingController, Navigator, MinimumTime]:
    """Made once in each process. No wall-time limit: a loaded machine decides the same."""
    setup = _with_plant(load_setup(config), plant)
    if solver:
        named = dataclasses.replace(setup.parameters.control, solver=solver)
        setup = dataclasses.replace(setup, parameters=dataclasses.replace(setup.parameters, control=named))
    control = dataclasses.replace(setup.parameters.control, prediction=_told(setup))
    controller = DockingController(setup.chair, setup.dock, control, deterministic=True, camera=setup.camera)
    controller.warm_up()
    navigator = Navigator(setup.chair, setup.dock, control, setup.parameters.planner, setup.camera)
    return setup, controller, navigator, MinimumTime(setup.chair, setup.dock, setup.dock.tolerance, mesh)


def _with_plant(setup: Setup, kind: str) -> Setup:
    if not kind:
        return setup
    plant = dataclasses.replace(setup.simulator.plant, kind=kind)
    return dataclasses.replace(setup, simulator=dataclasses.replace(setup.simulator, plant=plant))


def _told(setup: Setup) -> Prediction:
    """The times of the kinematic plant, whose limits of speed are judged to the millimetre per second; of a wheelchair
    nothing beyond config/controller.yaml."""
    told, plant = setup.parameters.control.prediction, setup.simulator.plant
    if plant.kind != KINEMATIC:
        return told
    return dataclasses.replace(told, command_delay=plant.kinematic.command_delay, motor_lag=plant.kinematic.lag_v)


def run_campaign_job(job: CampaignJob) -> dict[str, Any]:
    """The docking, the bound for its time, and the feedback laws from the same start."""
    setup, controller, navigator, minimum = _tools(job.config, job.solver, job.plant, job.mesh)
    run = DockingRun(setup, job.case, controller, job.noise, navigator)
    trajectory = run.run()
    result = run_values(run, trajectory, job.case)
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
    nearest = smallest_clearance(setup.chair, setup.dock.bay, run.poses[::2], obstacles)
    time = run.docking_time(setup.dock.tolerance)
    return {"docking_time_s": time, "min_clearance_m": nearest, "docked": time is not None and nearest > 0.0}


def run_campaign(
    config: str | Path,
    runs: int,
    *,
    seed: int = 1,
    solver: str = "",
    plant: str = "",
    workers: int | None = None,
    noise: NoiseModel | None = None,
    mesh: tuple[int, int] = STEPS,
    partial: Path | None = None,
) -> dict[str, Any]:
    """All runs, in the order of their index. `partial`: see run_long."""
    setup, noise = _with_plant(load_setup(config), plant), noise or NoiseModel()
    cases = draw_cases(setup, runs, seed, noise, True)
    jobs = [CampaignJob(str(config), case, solver, noise, plant, mesh) for case in cases]
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
        "told": "delay and lag of the plant" if setup.simulator.plant.kind == KINEMATIC else "nothing",
        "formulation": setup.parameters.control.formulation,
        "docking_time": "from the goal until the true pose stays within the tolerance",
        "minimum_time": "same limits and walls, to the set from which the tolerance need not be left; no obstacles",
        "minimum_time_steps": list(mesh),
    }
    return {"seed": seed, "conditions": conditions, "summary": summarize_runs(results), "runs": results}
