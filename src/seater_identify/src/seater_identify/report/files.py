"""Copies of controller.yaml and chair.yaml with the identified values; comments and everything else stay."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from seater_common.files.installation import IDENTIFIED
from seater_common.files.scalars import significant, with_note, with_values
from seater_identify.result.identify import Identification
from seater_identify.result.values import Estimate

# Estimate to key path in controller.yaml; several paths take the same value.
CONTROLLER = {
    "delay": "control/prediction/command_delay",
    "lag_v": "control/prediction/motor_lag",
    "lag_omega": "control/prediction/motor_lag_turning",
    "gain_v": "control/prediction/gain_v",
    "gain_omega": "control/prediction/gain_omega",
    "deadband_v": "control/prediction/deadband_v",
    "deadband_omega": "control/prediction/deadband_omega",
    "odometry_scale": "observer/odometry_scale",
    "odometry_heading_scale": "observer/odometry_heading_scale",
    "odometry_heading_drift": "observer/odometry_heading_drift",
}
SDS = {
    "odometry_scale": "observer/scale_sd",
    "odometry_heading_scale": "observer/heading_scale_sd",
    "odometry_heading_drift": "observer/heading_drift_sd",
}
SMALLEST_SD = 0.002  # a chair changes: tyres, load
LIMITS = {"ramp_v": "limits/a_max", "ramp_omega": "limits/alpha_max"}


def controller_values(result: Identification) -> dict[str, float]:
    """Key path to value, of what was identified."""
    values = {path: result[name].value for name, path in CONTROLLER.items() if result[name].usable}
    values |= {path: max(result[name].sd, SMALLEST_SD) for name, path in SDS.items() if result[name].usable}
    return values


def chair_values(result: Identification, limits: Mapping[str, float]) -> dict[str, float]:
    """Key path to value: limits above what the motor controller's ramp follows are lowered to it."""
    ramps: dict[str, Estimate] = {path: result[name] for name, path in LIMITS.items()}
    return {path: e.value for path, e in ramps.items() if e.usable and e.value < limits[path.partition("/")[2]]}


def write_copy(source: Path, target: Path, values: Mapping[str, float], note: str = "") -> Path:
    """`source` with these values, as `target`; `note`: of a first line that says where they come from, in the place of
    an earlier one. Raises ParameterError naming every key that `source` does not have."""
    target.parent.mkdir(parents=True, exist_ok=True)
    text = edited(source.read_text(), values, str(source))
    target.write_text(with_note(text, IDENTIFIED, note) if note else text)
    return target


def edited(text: str, values: Mapping[str, float], name: str) -> str:
    """The YAML text with new scalars at the key paths (a/b/c), its lines else as they are."""
    return with_values(text, {tuple(key.split("/")): value for key, value in values.items()}, name, significant)
