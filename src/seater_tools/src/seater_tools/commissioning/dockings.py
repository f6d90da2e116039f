"""Docks at the hidden installation with the files that the commands have written."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.files.installation import Installation
from seater_common.params import read_yaml
from seater_common.se2 import relative
from seater_eval.campaign.drive.docking import ImageDocking
from seater_eval.campaign.drive.starts import draw_start
from seater_eval.campaign.setup.campaign_file import Start
from seater_eval.campaign.setup.configuration import Configuration
from seater_eval.run.setup_files import SetupFiles, load_files
from seater_tools.commissioning.hidden import Hidden

Array = NDArray[np.float64]

LONGEST, REST = 180.0, 3.0  # [s] after which a docking is given up; after its result, to come to rest
BAR = (0.010, math.radians(1.0))  # [m], [rad] of the taught pose
STARTS = Start(x=[-2.8, -1.5], y=[-0.6, 0.6], heading=[-25.0, 25.0])


def configuration(hidden: Hidden, installation: Installation, config: Path) -> Configuration:
    """What the nodes are told, checked as they check it, and what is there. Raises ParameterError."""
    own = {role: installation.file(role) for role in ("chair", "dock", "controller", "camera")}
    told = SetupFiles(simulator=config / "simulator.yaml", perception=config / "perception.yaml", **own)
    setup, _ = load_files(told)
    return Configuration(
        chair=setup.chair,
        dock=setup.dock,
        simulated_chair=hidden.chair,
        simulated_dock=hidden.dock,
        parameters=setup.parameters,
        simulator=hidden.simulator,
        camera=setup.camera,
        simulated_camera=hidden.lens,
        perception=read_yaml(told.perception),
        dock_values=read_yaml(told.dock),
        mount_values=read_yaml(told.chair)["camera"],
        safety=read_yaml(config / "safety.yaml"),
        start=STARTS,
    )


def dock_once(c: Configuration, taught: Array, seed: int) -> dict[str, Any]:
    """One docking from a start of its own: how it ended, and how far from the pose `taught` (3,) the chair truly stands
    [m], [rad]. Raises NoStartError, and what any part of the chain raises."""
    start, _ = draw_start(c, seed)
    run = ImageDocking(c, c.parameters, start, seed, require_contact=False)
    run.run(LONGEST, REST)
    truth, result = run.simulator.truth, run.result
    off = relative(taught, truth.pose)
    there = math.hypot(off[0], off[1]) <= BAR[0] and abs(off[2]) <= BAR[1]
    success = result is not None and result.success
    return {
        "seed": seed,
        "start": np.asarray(start).tolist(),
        "result": "UNFINISHED" if result is None else result.code.name,
        "text": "no result within the longest time" if result is None else result.text,
        "seconds": None if result is None else result.duration,
        "retries": None if result is None else result.retries,
        "off": off.tolist(),
        "touched": truth.collisions > 0,
        "docked": bool(success and there),
    }
