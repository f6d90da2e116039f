"""One case of a campaign, from its seed to its row of the table. Whatever goes wrong is in the row."""

from __future__ import annotations

import math
import time
import traceback
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.baselines.trajectories import Trajectory
from seater_eval.campaign.drive import tools
from seater_eval.campaign.drive.comfort import comfort
from seater_eval.campaign.drive.docking import ImageDocking
from seater_eval.campaign.drive.starts import NoStartError, draw_start
from seater_eval.campaign.setup.campaign_file import Campaign
from seater_eval.campaign.setup.cases import Case, case_of_seed
from seater_eval.campaign.setup.configuration import Configuration, Files
from seater_eval.campaign.setup.told import told_parameters
from seater_nmpc.sequence.rest.verification import within

Array = NDArray[np.float64]

# Results beside the names of seater_nmpc's ResultCode: a configuration that no node would start with, no start of the
# wanted kind, an exception or a process that died, no result within the longest time.
REFUSED, NO_START, CRASHED, UNFINISHED = "REFUSED", "NO_START", "CRASHED", "UNFINISHED"
_PATH_EVERY = 0.2  # [s] between two poses of the path that is kept
_STANDS = 1e-3  # [m/s, rad/s] true speeds at the end below which the chair is at rest


_NOTHING_HAPPENED = {"docked": False, "touched": False, "at_rest": None}

Started = tuple[Configuration, ImageDocking]


@dataclass(frozen=True)
class CampaignJob:
    """All that a case depends on. It is sent to other processes and machines."""

    files: Files
    campaign: Campaign
    told: str
    seed: int  # the case's own
    index: int
    bound: bool = False  # the shortest possible time is computed, too
    images: bool = True  # False: poses are drawn, see without_images


def run_case(job: CampaignJob) -> dict[str, Any]:
    """The row of the table: what was drawn, how it ended, what was measured. Never raises."""
    return docking_row(job)[0]


def process_died(job: CampaignJob) -> dict[str, Any]:
    """The row of a case whose process ended in the middle of it."""
    return _begun(job) | {"result": CRASHED, "text": "the process died (out of memory, or a fault in compiled code)"}


def docking_row(job: CampaignJob) -> tuple[dict[str, Any], Started | None]:
    """The same with the docking itself, as far as it came; None where it did not begin."""
    cv2.setNumThreads(1)
    begin = time.process_time()
    row = _begun(job)
    started: Started | None = None
    ended: dict[str, Any] = {}
    try:
        case = case_of_seed(job.files, job.campaign, job.seed, job.index)
        row |= {"variants": case.variants, "numbers": case.numbers}
        started = prepare(job, case)
        settings = job.campaign.settings
        started[1].run(settings.longest, settings.rest)
    except Exception as error:  # a campaign goes on: the row says what happened, and the case can be replayed
        ended = _why(error, started is not None)
        row |= ended
    if started is not None and started[1].trace.truth_rows:
        row = row | docking_values(*started) | ({"docked": False} | ended if ended else {})
    row["core_s"] = time.process_time() - begin
    if job.bound and row["docked"] and started is not None:
        row |= _bound(started[0], row)
    return row, started


def _bound(c: Configuration, row: dict[str, Any]) -> dict[str, Any]:
    """The shortest time from this start, and how many times longer it took to arrive; None without a solution."""
    shortest = tools.minimum_time(c.simulated_chair, c.simulated_dock).solve(row["start"])
    time_s, arrival = None if shortest is None else shortest.time, row["arrival_time_s"]
    ratio = arrival / time_s if time_s and arrival is not None else None
    return {"minimum_time_s": time_s, "time_ratio": ratio}


def _why(error: Exception, began: bool) -> dict[str, Any]:
    """Result and text of a case that ended without a result of the docking sequence."""
    if isinstance(error, NoStartError):
        return {"result": NO_START, "text": str(error)}
    if isinstance(error, ValueError) and not began:
        return {"result": REFUSED, "text": str(error)}
    return {"result": CRASHED, "text": "".join(traceback.format_exception(error)[-3:])}


def _begun(job: CampaignJob) -> dict[str, Any]:
    """What every row has, whatever happened."""
    return {"index": job.index, "seed": job.seed, **_NOTHING_HAPPENED}


def prepare(job: CampaignJob, case: Case) -> Started:
    """The docking of a case, before its first step. Raises ValueError where a node would refuse to start."""
    c = case.configuration(job.files, job.campaign)
    start, rough = draw_start(c, case.seed, images=job.images)
    parameters = told_parameters(c.parameters, c.simulator, c.simulated_chair, job.told, case.seed)
    contact = job.campaign.settings.require_contact
    run = ImageDocking(c, parameters, start, case.seed, require_contact=contact, rough_pose=rough, images=job.images)
    return c, run


def docking_values(c: Configuration, run: ImageDocking) -> dict[str, Any]:
    """What is kept of a run: result, true errors, comfort, times, a thinned path."""
    truth, result, trace = run.simulator.truth, run.result, run.trace.truth
    errors = trace[:, 1:4] - c.simulated_dock.docked_pose
    error = c.simulated_dock.docking_error(truth.pose)
    at_rest = abs(truth.v) < _STANDS and abs(truth.omega) < _STANDS
    docked = bool(result is not None and result.success and within(error, c.dock.tolerance) and at_rest)
    every = max(1, round(_PATH_EVERY / c.simulator.step))
    images, cycles = run.trace.images, run.trace.cycles
    known = cycles[np.isfinite(cycles[:, 6])] if len(cycles) else cycles
    return {
        "start": trace[0, 1:4].tolist(),
        "docked": docked,
        "touched": truth.collisions > 0,
        "at_rest": at_rest,
        "result": UNFINISHED if result is None else result.code.name,
        "text": "no result within the longest time" if result is None else result.text,
        "retries": 0 if result is None else result.retries,
        "docking_time_s": None if result is None else result.duration,
        "arrival_time_s": Trajectory(trace[:, 0], errors, trace[:, 4:6]).docking_time(c.dock.tolerance),
        "position_error_m": math.hypot(error[0], error[1]),
        "longitudinal_error_m": float(error[0]),
        "lateral_error_m": float(error[1]),
        "heading_error_deg": math.degrees(error[2]),
        "estimate_position_error_m": math.hypot(*known[-1, 6:8]) if len(known) else None,
        "estimate_heading_error_deg": math.degrees(known[-1, 8]) if len(known) else None,
        "min_clearance_m": truth.min_clearance,
        "contact": truth.contact,
        "images": len(images),
        "images_with_markers": int(np.sum(images[:, 1] > 0)) if len(images) else 0,
        "gate_limited": run.gate.limited,
        "gate_refused": run.gate.refused,
        "simulated_s": float(trace[-1, 0]),
        **comfort(trace[:, 0], trace[:, 4], trace[:, 5]),
        **{f"core_{part}_s": seconds for part, seconds in sorted(run.clock.seconds.items())},
        "path": np.round(trace[::every, 1:4], 4).tolist(),
    }
