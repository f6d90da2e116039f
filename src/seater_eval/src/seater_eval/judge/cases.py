"""Named rows of the evaluation: which effects, how large, and where the chair starts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seater_common.geometry import Chair, Dock
from seater_eval.judge.plant.camera import DockCamera
from seater_eval.judge.plant.effects import Effects, changed, kinematic
from seater_eval.judge.plant.faults import Fault
from seater_eval.judge.plant.installation import Installation
from seater_eval.judge.verdict import smallest_gap

Start = tuple[float, float, float]

STARTS = ("front", "beside", "turned")
_CLEAR = 0.1  # [m] from every wall
_CAMERA_RATES, _ODOMETRY_RATES = (10, 5, 3), (200, 50, 20, 10, 5)  # [Hz]
_VIEWS = (69, 62)  # [deg] horizontally: D435's colour camera, Raspberry Pi camera 2
_GYRO_BIAS = 0.03  # [rad/s]


@dataclass(frozen=True)
class Row:
    """One row of the table."""

    name: str
    effects: Effects
    starts: str = "front"
    markers: int = 0  # so many of the dock's markers, the first ones; 0: all
    fault: Fault | None = None
    installation: Installation | None = None


def _effect(group: str, **values: object) -> Callable[[float], Effects]:
    """From a factor to a chair with these effects alone, times the factor."""

    def make(factor: float) -> Effects:
        return changed(kinematic(), group, **{key: _times(value, factor) for key, value in values.items()})

    return make


def _times(value: object, factor: float) -> object:
    if isinstance(value, tuple):
        return tuple(factor * entry for entry in value)
    return factor * value if isinstance(value, float) else value


_WHOLE = Effects()
_D, _F, _P = _WHOLE.drive, _WHOLE.floor, _WHOLE.pictures
# Each at the values of the whole plant and at twice them.
_ALONE: dict[str, Callable[[float], Effects]] = {
    "deadband_v": _effect("drive", deadband_v=_D.deadband_v),
    "deadband_omega": _effect("drive", deadband_omega=_D.deadband_omega),
    "deadband_offset": _effect(
        "drive", deadband_v=_D.deadband_v, deadband_omega=_D.deadband_omega, deadband_kind="offset"
    ),
    "deadband_stiction": _effect(
        "drive", deadband_v=_D.deadband_v, deadband_omega=_D.deadband_omega, deadband_kind="stiction"
    ),
    "delay": _effect("drive", delay=_D.delay),
    "delay_jitter": _effect("drive", delay_jitter=0.05),
    "lag": _effect("drive", lag=_D.lag),
    "slip": _effect("floor", slip=_F.slip),
    "slip_patches": _effect("floor", patch_slip=_F.patch_slip),
    "castors": _effect("floor", castor_omega=_F.castor_omega, castor_v=_F.castor_v),
    "slope": _effect("floor", slope=_F.slope),
    "asymmetry": _effect("floor", weaker=_F.weaker),
    "radii": _effect("floor", radius=_F.radius, track=_F.track),
    "outliers": _effect("pictures", outliers=_P.outliers),
    "flips": _effect("pictures", flips=_P.flips),
    "camera_latency": _effect("pictures", latency=_P.latency),
    "odometry_jitter": _effect("encoders", jitter=0.02),
    "odometry_reordered": _effect("encoders", jitter=0.03, ordered=False),
    "gyro_bias": _effect("encoders", gyro_bias=_GYRO_BIAS),
    "gyro_drift": _effect("encoders", gyro_bias=_GYRO_BIAS, gyro_in_pose=True),
}


def rows() -> dict[str, list[Row]]:
    """The rows of each set, by the set's name; a row's own name is a set, too (NAME_1x: the first row of NAME)."""
    still = changed(_WHOLE, "drive", deadband_v=0.0, deadband_omega=0.0)
    sets = {
        "issue": [Row("issue", _WHOLE)],
        "no_deadband": [Row("no_deadband", still)],
        "kinematic": [Row("kinematic", kinematic())],
        "beside": [Row("beside", _WHOLE, "beside")],
        "turned": [Row("turned", _WHOLE, "turned")],
        "single_marker": [
            Row("single_marker", changed(_WHOLE, "pictures", flips=0.0, ambiguous=True), markers=1),
            Row("single_marker_alone", changed(kinematic(), "pictures", ambiguous=True), markers=1),
        ],
        "narrow_view": [
            Row(f"narrow_view_{view}", changed(_WHOLE, "pictures", view=math.radians(view))) for view in _VIEWS
        ],
    }
    for name, make in _ALONE.items():
        sets[name] = [Row(name, make(1.0)), Row(f"{name}_2x", make(2.0))]
    sets["camera_rate"] = [
        Row(f"camera_rate_{rate}", changed(kinematic(), "pictures", rate=float(rate))) for rate in _CAMERA_RATES
    ]
    sets["odometry_rate"] = [
        Row(f"odometry_rate_{rate}", changed(kinematic(), "encoders", rate=float(rate))) for rate in _ODOMETRY_RATES
    ]
    sets["zero_twist"] = [Row("zero_twist", changed(kinematic(), "encoders", zero_twist=True))]
    alone = [*_ALONE, "camera_rate", "odometry_rate", "zero_twist"]
    single = {row.name: [row] for members in sets.values() for row in members if row.name not in sets}
    single |= {f"{name}_1x": members[:1] for name, members in sets.items() if members[0].name == name and members[1:]}
    return {**sets, **single, "effects": [row for name in alone for row in sets[name]]}


def draw_start(kind: str, chair: Chair, dock: Dock, camera: DockCamera, rng: np.random.Generator) -> Start:
    """front: x -4..-1 m, y +-1.5 m, heading +-60 deg, a marker in view; beside: beside the bay, heading +-60 deg;
    turned: as front, then turned away by 90-180 deg. Always 0.1 m clear of the walls."""
    for _ in range(10000):
        heading = math.radians(rng.uniform(-60.0, 60.0))
        if kind == "beside":
            pose = (rng.uniform(-1.5, -0.5), rng.uniform(1.0, 2.0) * rng.choice([-1.0, 1.0]), heading)
        else:
            pose = (rng.uniform(-4.0, -1.0), rng.uniform(-1.5, 1.5), heading)
            if not camera.seen(pose):
                continue
        if kind == "turned":
            away = math.radians(rng.uniform(90.0, 180.0)) * rng.choice([-1.0, 1.0])
            pose = (pose[0], pose[1], math.remainder(heading + away, 2.0 * math.pi))
        if smallest_gap(np.array([pose]), chair, dock) >= _CLEAR:
            return float(pose[0]), float(pose[1]), float(pose[2])
    raise RuntimeError("no start found")
