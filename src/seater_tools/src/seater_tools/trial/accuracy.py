"""Calibrations of random installations against the truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angle
from seater_sim.chair.plant_ranges import PlantRanges
from seater_sim.settings import SimulatorSettings
from seater_tools.mount.gauge import held_still
from seater_tools.mount.layout import MOUNT
from seater_tools.mount.prior import TAPE, Lengths
from seater_tools.mount.result import judge
from seater_tools.mount.solve import solve
from seater_tools.trial.seen import simulate_drive
from seater_tools.trial.truth import Errors, Installation, draw_installation

Array = NDArray[np.float64]

LEAN = math.radians(0.6)  # of prints that were hung by a level
# Bars: position and angles of the mount, place of the markers along each axis; none for the rest.
BARS = {
    "mount": 0.002,
    "mount angle": 0.001,
    "marker": 0.001,
    "marker direction": math.inf,
    "marker size": math.inf,
}


@dataclass(frozen=True)
class Trial:
    """Errors and standard deviations [m], [rad]; of a kind of BARS, all values of this installation together."""

    seed: int
    missing: list[str]
    errors: Mapping[str, list[float]]
    sds: Mapping[str, list[float]]


def run_trial(
    ranges: PlantRanges, base: SimulatorSettings, chair: Chair, dock: Dock, camera: CameraModel, seed: int
) -> Trial:
    """Another chair, dock and mount for each seed. A tape between the markers that are farthest apart is read with the
    noise that the calibration assumes."""
    rng = np.random.default_rng(seed)
    simulator = ranges.draw_simulator(rng, base)
    truth = draw_installation(chair.camera, dock, Errors(lean=LEAN), rng)
    drive = simulate_drive(truth, camera, simulator, chair.limits, seed)
    lengths = Lengths(distances=(_tape(truth, rng),))
    calibration = judge(solve(drive, camera, chair.camera, dock, lengths), dock, lengths)
    file, rows = _rows(dock), _rows(truth.dock)
    rows[:, 3] = file[:, 3] + [wrap_angle(a - b) for a, b in zip(rows[:, 3], file[:, 3], strict=True)]
    rows, motion = held_still(file, rows)
    errors: dict[str, list[float]] = {kind: [] for kind in BARS}
    sds: dict[str, list[float]] = {kind: [] for kind in BARS}
    for value in calibration.mount:
        true = getattr(truth.mount, value.name) + (motion[2] if value.name == "z" else 0.0)
        kind = "mount" if MOUNT.index(value.name) < 3 else "mount angle"
        errors[kind].append(value.value - true)
        sds[kind].append(value.sd)
    for marker, row in zip(truth.dock.markers, rows, strict=True):
        for value, true in zip(calibration.markers[marker.id], [*row, marker.size], strict=True):
            kind = {"yaw": "marker direction", "size": "marker size"}.get(value.name, "marker")
            off = value.value - true
            errors[kind].append(wrap_angle(off) if value.name == "yaw" else off)
            sds[kind].append(value.sd)
    return Trial(seed, calibration.missing, errors, sds)


def shares(trials: Sequence[Trial], kind: str) -> dict[str, float]:
    """Of a kind of value: rms and largest error, part within the bar, part within 95 % intervals."""
    off = np.concatenate([trial.errors[kind] for trial in trials])
    sd = np.concatenate([trial.sds[kind] for trial in trials])
    return {
        "rms": float(np.sqrt(np.mean(off**2))),
        "largest": float(np.abs(off).max()),
        "in_bar": float(np.mean(np.abs(off) <= BARS[kind])),
        "in_interval": float(np.mean(np.abs(off) <= 1.96 * sd)),
    }


def _rows(dock: Dock) -> Array:
    return np.array([[*marker.position, marker.normal_yaw] for marker in dock.markers])


def _tape(truth: Installation, rng: np.random.Generator) -> tuple[int, int, float]:
    markers = truth.dock.markers
    pairs = [(math.dist(a.position, b.position), a.id, b.id) for a in markers for b in markers if a.id < b.id]
    distance, a, b = max(pairs)
    return a, b, distance + TAPE * float(rng.standard_normal())
