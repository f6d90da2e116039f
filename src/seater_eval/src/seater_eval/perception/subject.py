"""seater_perception itself, through its Python binding: the code that the nodelet runs."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.params import ParameterError, read_yaml
from seater_eval.perception.images.degraded_camera import DegradedCamera
from seater_eval.perception.peers import Detector, Seen

DICTIONARY = "DICT_4X4_50"


def perception_parameters(config: str | Path) -> dict[str, Any]:
    """config/perception.yaml, but without its allowance for what a real camera and print deviate from the model: the
    images here are exactly what the model assumes. Raises ParameterError."""
    path = Path(config) / "perception.yaml"
    values = read_yaml(path)
    values = copy.deepcopy(values)
    if isinstance(values, dict) and isinstance(values.get("pose"), dict) and "model_sigma" in values["pose"]:
        values["pose"]["model_sigma"] = values["pose"]["placement_sigma"] = 0.0
    return dict(values) if isinstance(values, dict) else {}


def camera_model(camera: DegradedCamera) -> sp.CameraModel:
    """The library's camera."""
    K = [float(k) for k in camera.K.ravel()]
    return sp.CameraModel.raw(sp.Calibration(camera.image_width, camera.image_height, K, [0.0] * 5))


def layout(size: float, prior: bool, ids: tuple[int, ...] = (0,), dictionary: str = DICTIONARY) -> sp.DockLayout:
    """Markers of one size [m]; `prior`: known to stand upright (as a dock's do)."""
    if not prior:
        return sp.layout_of_equal_markers(dictionary, size)
    markers = [{"id": i, "size": size, "position": [1.0, 0.5 * i, 0.7], "normal_yaw": 3.14159} for i in ids]
    return sp.load_dock_layout({"dictionary": dictionary, "markers": markers})


def make_detector(
    camera: DegradedCamera,
    size: float,
    parameters: dict[str, Any],
    *,
    prior: bool,
    tracking: bool = False,
    ids: tuple[int, ...] = (0,),
) -> Any:
    """A DockDetector, or a DockTracker. Raises ParameterError naming the key."""
    if tracking and not parameters.get("tracking", {}).get("enabled", True):
        raise ParameterError("perception/tracking/enabled: is false, must be true where tracking is measured")
    kind = sp.DockTracker if tracking else sp.DockDetector
    try:
        return kind(camera_model(camera), layout(size, prior, ids), parameters)
    except sp.ConfigurationError as error:
        raise ParameterError(str(error)) from error


def result_files(config: str | Path) -> list[Path]:
    """What the results of a perception command depend on beside Python code: see run_long."""
    return [*Path(config).rglob("*.yaml"), *library_files()]


def library_files() -> list[Path]:
    """The files of the library and its Python module as they are loaded in this process."""
    maps = Path("/proc/self/maps").read_text().splitlines()
    return sorted({Path(line.split()[-1]) for line in maps if "seater_perception" in line and ".so" in line})


def as_peer(detector: Any) -> Detector:
    """The same interface as the peers'."""

    def detect(image: NDArray[np.uint8]) -> list[Seen]:
        return [Seen(m.id, m.corners, m.hypotheses[0].pose) for m in detector.detect(image).markers]

    return detect
