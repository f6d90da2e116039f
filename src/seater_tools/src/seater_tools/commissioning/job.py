"""One installation from its seed to its row of the table. Whatever goes wrong is in the row."""

from __future__ import annotations

import shutil
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.files.installation import Installation
from seater_eval.run.parallel import job_seed
from seater_tools.commissioning.dockings import configuration, dock_once
from seater_tools.commissioning.errors import chair_errors, dock_errors, lens_errors, mount_errors
from seater_tools.commissioning.hidden import Hidden, draw_hidden
from seater_tools.commissioning.steps import people_minutes
from seater_tools.commissioning.technician import StepError, Technician
from seater_tools.trial.drive import SCRIPT, Script

Array = NDArray[np.float64]

COMMANDS = ("sheets", "lens", "mount", "identify", "teach", "doctor")


@dataclass(frozen=True)
class Job:
    """`folder`: of all installations; `keep`: what the commands wrote stays there, bags and photographs too."""

    config: Path
    folder: Path
    seed: int
    dockings: int
    keep: bool


def commission(job: Job) -> dict[str, Any]:
    """The row of the installation that the seed draws."""
    return commission_at(draw_hidden(job.config, job.seed), job)


def commission_at(
    hidden: Hidden, job: Job, script: Script = SCRIPT, commands: Sequence[str] = COMMANDS
) -> dict[str, Any]:
    """The row; whatever a command or a docking raises is in it. `script`: of the drive for the mount; `commands`: which
    of COMMANDS are given.

    docked: all dockings ended within the bar. failed, why: the step that ended it, and what its command said.
    """
    cv2.setNumThreads(1)
    begin, folder = time.process_time(), job.folder / f"{job.seed}"
    shutil.rmtree(folder, ignore_errors=True)
    technician = Technician(hidden, job.config, folder, script)
    row: dict[str, Any] = {
        "seed": job.seed,
        "plant": hidden.plant,
        "bars": bool(hidden.bars),
        "failed": None,
        "why": "",
    }
    row |= {"dockings": [], "errors": {}, "docked": False}
    step = ""
    try:
        for step in commands:
            getattr(technician, step)()
        taught = technician.taught
        assert taught is not None  # teaching is one of COMMANDS
        row["errors"] = _errors(hidden, technician.installation, taught)
        step = "dockings"
        c = configuration(hidden, technician.installation, job.config)
        for index in range(job.dockings):
            row["dockings"].append(dock_once(c, taught, job_seed(job.seed, index)))
    except StepError as error:
        row |= {"failed": step, "why": str(error)}
    except Exception as error:  # the campaign goes on
        row |= {"failed": step, "why": "".join(traceback.format_exception(error)[-3:])}
    ended = [d["seconds"] for d in row["dockings"] if d["seconds"] is not None]
    seconds = technician.seconds | ({"dockings": float(sum(ended))} if ended else {})
    row |= {"notes": technician.notes, "driving_s": seconds}
    row["minutes"] = people_minutes() + sum(seconds.values()) / 60.0
    row["docked"] = row["failed"] is None and all(d["docked"] for d in row["dockings"])
    row["core_s"] = time.process_time() - begin
    if not job.keep:
        _tidy(folder)
    return row


def _errors(hidden: Hidden, installation: Installation, taught: Array) -> dict[str, dict[str, float]]:
    file = installation.file
    return {
        "lens": lens_errors(hidden, file("camera")),
        "mount": mount_errors(hidden, file("chair")),
        "identify": chair_errors(hidden, file("controller")),
        "dock": dock_errors(hidden, file("dock"), taught),
    }


def _tidy(folder: Path) -> None:
    """Bags and photographs are large."""
    shutil.rmtree(folder / "photographs", ignore_errors=True)
    for bag in folder.glob("*.bag"):
        bag.unlink()
