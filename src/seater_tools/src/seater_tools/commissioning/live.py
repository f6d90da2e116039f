"""What the doctor says while everything runs at the hidden installation, with its short drive."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np

from seater_common.files.installation import Installation
from seater_common.geometry import Chair
from seater_common.params import load, read_yaml
from seater_tools.commissioning.hidden import Hidden
from seater_tools.doctor.checks import run
from seater_tools.doctor.gather.machine import look_at_files
from seater_tools.doctor.observations import Machine, Traffic
from seater_tools.doctor.trial.scene import FILES, SENDERS, Scene
from seater_tools.doctor.trial.watch import Watch

STANDS = -1.0  # [m] in the dock frame: the camera is about 1.4 m before the markers


def live_crosses(hidden: Hidden, installation: Installation, config: Path) -> list[str]:
    """What it holds to be wrong; of a good installation, nothing."""
    own = {role: installation.file(role) for role in ("chair", "dock", "camera", "controller")}
    files = look_at_files({role: own.get(role, config / name) for role, name in FILES.items()})
    told = {role: copy.deepcopy(file.values) for role, file in files.items()}
    scene = Scene(
        seed=hidden.seed,
        files=files,
        chair=hidden.chair,
        dock=hidden.dock,
        camera=hidden.lens,
        simulator=hidden.simulator,
        start=np.array([STANDS, 0.0, 0.0]),
        told=told,
        info=told["camera"],
        T_base_optical=load(Chair, read_yaml(own["chair"]), "chair").camera.T_base_optical(),
        machine=Machine(folder="log", free=50e9, busy=0.5),
        traffic={role: Traffic(f"/{role}", (node,), ("/someone",)) for role, node in SENDERS.items()},
        drive=True,
    )
    verdicts = run(Watch(scene).observe())
    return [f"{v.name}: {v.what}" for v in verdicts if v.ok is False]
