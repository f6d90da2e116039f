"""The calibration as text and as JSON."""

from __future__ import annotations

import dataclasses
import json
import math

from seater_tools.mount.result import Calibration, Value

_PRINTED = {"m": ("mm", 1000.0, 1), "rad": ("deg", math.degrees(1.0), 3), "px": ("px", 1.0, 2)}  # unit, factor, digits


def describe(calibration: Calibration) -> str:
    """For the terminal: millimetres and degrees, each with its standard deviation."""
    lines = [f"{calibration.images} images; corners are off by {calibration.corner_rms:.3f} px", "camera on the chair"]
    lines += [_line(value) for value in calibration.mount]
    for id, values in calibration.markers.items():
        lines += [f"marker {id}", *(_line(value) for value in values)]
    lines += ["lens", *(_line(value) for value in calibration.lens)] if calibration.lens else []
    lines.append("odometry against the images")
    lines += [f"  {v.name:<14} {v.value:9.4f} +- {v.sd:.4f}" for v in calibration.odometry]
    return "\n".join([*lines, "", *calibration.notes])


def as_json(calibration: Calibration) -> bytes:
    """SI units; a standard deviation that is not finite becomes null."""
    values = dataclasses.asdict(calibration)
    return (json.dumps(_finite(values), indent=1) + "\n").encode()


def _line(value: Value) -> str:
    unit, factor, digits = _PRINTED[value.unit]
    old, new = f"{factor * value.file:9.{digits}f}", f"{factor * value.value:9.{digits}f}"
    if value.kept:
        return f"  {value.name:<6} {old} {unit} kept"
    return f"  {value.name:<6} {old} -> {new} +- {factor * value.sd:.{digits + 1}f} {unit}"


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {str(key): _finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
