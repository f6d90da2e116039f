"""Copies of controller.yaml and chair.yaml with the identified values; comments and everything else stay."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from seater_common.files.installation import IDENTIFIED
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
LINE = re.compile(r"^(?P<indent> *)(?P<key>[A-Za-z_]\w*):(?P<space>[ \t]*)(?P<value>[^#\n]*?)(?P<rest>[ \t]*(?:#.*)?)$")


class KeyPathError(ValueError):
    """A file has no such key."""


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
    an earlier one. Raises KeyPathError naming every key that `source` does not have."""
    target.parent.mkdir(parents=True, exist_ok=True)
    text = edited(source.read_text(), values, str(source))
    if note:
        rest = "".join(line for line in text.splitlines(keepends=True) if not line.startswith(IDENTIFIED))
        text = f"{IDENTIFIED}{note}\n{rest}"
    target.write_text(text)
    return target


def edited(text: str, values: Mapping[str, float], name: str) -> str:
    """The YAML text with new scalars at the key paths (a/b/c), its lines else as they are."""
    lines, left, path = text.split("\n"), dict(values), list[tuple[int, str]]()
    for index, line in enumerate(lines):
        match = LINE.match(line)
        if match is None:
            continue
        while path and path[-1][0] >= len(match["indent"]):
            path.pop()
        path.append((len(match["indent"]), match["key"]))
        key = "/".join(part for _, part in path)
        if key in left and match["value"]:
            lines[index] = _replaced(match, left.pop(key))
    if left:
        raise KeyPathError(f"{name}: has no {', '.join(sorted(left))}")
    return "\n".join(lines)


def _replaced(match: re.Match[str], value: float) -> str:
    """The line with a new value; its comment stays in its column where there is room."""
    head, new = f"{match['indent']}{match['key']}:{match['space']}", f"{value:.4g}"
    if "." not in new:  # YAML 1.1 takes 1e-05 for a text
        digits, e, power = new.partition("e")
        new = f"{digits}.0{e}{power}"
    comment = match["rest"].lstrip()
    if not comment:
        return head + new
    width = len(head) + len(match["value"]) + len(match["rest"]) - len(comment)
    return (head + new).ljust(max(width, len(head + new) + 1)) + comment
