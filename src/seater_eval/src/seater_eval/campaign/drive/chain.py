"""What lies between the camera and the motors beside the docking core: the perception library and the safety gate.

Both are the compiled code that the nodes run, by their Python modules.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
import seater_safety
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair
from seater_common.params import ParameterError
from seater_eval.campaign.setup.configuration import Configuration
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight

Image = NDArray[np.uint8]

_GATE = seater_safety.describe_parameters()
_FOOTPRINT = [entry["key"] for entry in _GATE if entry["file"] == "chair"]
_LIMITS = [entry["key"] for entry in _GATE if entry["file"] == "chair/limits"]  # of the chair that the gate knows
_SAFETY = [entry["key"] for entry in _GATE if entry["file"] == "safety"]  # keys of config/safety.yaml


class Perception:
    """Images of one run, in their order, to possible poses of the dock: what the nodelet makes of a camera's topics."""

    def __init__(self, configuration: Configuration) -> None:
        """Raises ParameterError, naming the key."""
        self._tracker = self._make(sp.DockTracker, configuration)
        self._detector_of = lambda: self._make(sp.DockDetector, configuration)

    @staticmethod
    def _make(kind: Any, c: Configuration) -> Any:
        try:
            layout = sp.load_dock_layout(c.dock_values)
            return kind(_camera(c.camera), layout, c.perception, c.mount_values)
        except ValueError as error:  # the library's own errors
            raise ParameterError(f"perception: {error}") from error

    def detect(self, image: Image) -> tuple[list[Hypothesis], list[MarkerSight]]:
        """The dock's possible poses in the optical frame and the markers, as the topic `detections` carries them."""
        result = self._tracker.detect(image)
        markers = [MarkerSight(marker.id, marker.hypotheses[0].pose) for marker in result.markers]
        return [Hypothesis(seen.pose, seen.covariance, seen.weight) for seen in result.dock], markers

    def finds(self, image: Image) -> bool:
        """Whether the dock is found in a single image, whatever was seen before; leaves no trace in the run."""
        return bool(self._detector_of().detect(image).dock)


def _camera(camera: CameraModel) -> sp.CameraModel:
    """The library's model of the raw images."""
    K, D, P = ([float(value) for value in matrix.ravel()] for matrix in (camera.K, camera.D, camera.P))
    return sp.CameraModel.raw(sp.Calibration(camera.width, camera.height, K, D, camera.distortion_model, P))


class Gate:
    """The velocity gate as the node safety_gate has it: from the chair's limits and config/safety.yaml. It has the
    consent for the one goal of the run."""

    def __init__(self, chair: Chair, safety: dict[str, float]) -> None:
        """Raises ParameterError, naming the key."""
        missing = [key for key in _SAFETY if not isinstance(safety.get(key), int | float)]
        if missing:
            raise ParameterError(f"safety/{missing[0]}: is {safety.get(missing[0])!r}, must be a number")
        values = {key: float(value) for key, value in safety.items()}
        values |= {key: getattr(chair.limits, key) for key in _LIMITS}
        values |= {key: getattr(chair, key) for key in _FOOTPRINT}
        try:
            self._gate = seater_safety.VelocityGate(**values)
        except ValueError as error:
            raise ParameterError(f"safety/{error}") from error
        self._armed = False

    def pass_on(self, now: float, v: float, omega: float) -> tuple[float, float]:
        """The command for the motors after a request of the docking node [m/s, rad/s]."""
        if not self._armed:
            self._gate.arm(now)
            self._armed = True
        self._gate.request(now, v, omega)
        return self.output(now)

    def output(self, now: float) -> tuple[float, float]:
        """The command for the motors without a new request."""
        v, omega = self._gate.output(now)
        return float(v), float(omega)

    @property
    def limited(self) -> int:
        """Requests beyond the chair's speed limits so far."""
        return int(self._gate.limited)

    @property
    def refused(self) -> int:
        """Requests that were not finite so far."""
        return int(self._gate.refused)
