"""What the commands have written, less the truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import load_file, read_yaml
from seater_common.se2 import inverse, transform_points, wrap_angle
from seater_identify.report.files import CONTROLLER
from seater_identify.trial.truth import true_values
from seater_tools.commissioning.hidden import Hidden

Array = NDArray[np.float64]


def lens_errors(hidden: Hidden, path: Path) -> dict[str, float]:
    """Relative error of the focal length."""
    return {"focal": float(CameraModel.load(path).K[0, 0] / hidden.lens.K[0, 0]) - 1.0}


def mount_errors(hidden: Hidden, path: Path) -> dict[str, float]:
    """[m], [rad]; without z, of which only the height of the markers over the camera counts."""
    found, true = load_file(Chair, path).camera, hidden.chair.camera
    return {name: getattr(found, name) - getattr(true, name) for name in ("x", "y", "roll", "pitch", "yaw")}


def chair_errors(hidden: Hidden, path: Path) -> dict[str, float]:
    """Of the values of controller.yaml, identified or not."""
    values, true = read_yaml(path), true_values(hidden.simulator, hidden.chair.limits)
    errors = {}
    for name, key in CONTROLLER.items():
        value = values
        for part in key.split("/"):
            value = value[part]
        errors[name] = float(value) - true[name]
    return errors


def dock_errors(hidden: Hidden, path: Path, taught: Array) -> dict[str, float]:
    """Of the markers in the frame of the true taught pose (3,): largest in place [m], direction [rad], size (relative).
    Teaching takes an error of the mount along, so that it shows here."""
    found = {marker.id: marker for marker in load_file(Dock, path).markers}
    place, turn, size = [], [], []
    for true in hidden.dock.markers:
        marker = found[true.id]
        xy = transform_points(inverse(taught), np.array([true.position[:2]]))[0]
        place.append(float(np.linalg.norm(xy - marker.position[:2])))
        turn.append(abs(wrap_angle(marker.normal_yaw - (true.normal_yaw - float(taught[2])))))
        size.append(abs(marker.size / true.size - 1.0))
    return {"marker": max(place), "direction": max(turn), "size": max(size)}
