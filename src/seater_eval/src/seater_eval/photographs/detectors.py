"""Detectors of photographs, one interface: what they find in one, and the processor time that they take."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_eval.perception.peers import detector_parameters
from seater_eval.photographs.truth import Photograph, PhotographFolder

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
SEATER, OPENCV = "seater", "opencv_default"


@dataclass(frozen=True, kw_only=True)
class Found:
    """A marker as a detector reports it. Poses count in the side of the marker."""

    id: int
    corners: Array  # (4, 2) [px]: top left first, clockwise as the print is read
    pose: Array | None = None  # (4, 4) T_optical_marker, the most probable one
    covariance: Array | None = None  # (6, 6) of it, all hypotheses together
    ambiguity: float = 0.0
    stage: str = ""  # what the pose was fitted to


@dataclass(frozen=True, kw_only=True)
class Detection:
    """What one detector says about one photograph."""

    found: list[Found]
    milliseconds: float  # of processor time, all threads


Detector = Callable[[Image], list[Found]]


def make_detector(
    name: str, folder: PhotographFolder, photograph: Photograph, parameters: dict[str, Any] | None
) -> Detector:
    """`parameters`: config/perception.yaml as a mapping, for SEATER. Raises ParameterError; KeyError: other name."""
    return {SEATER: _seater, OPENCV: _opencv}[name](folder, photograph, parameters)


def timed(detect: Detector, image: Image) -> Detection:
    """One look; libraries have been loaded and tables been made by an earlier one."""
    start = time.process_time()
    found = detect(image)
    return Detection(found=found, milliseconds=1e3 * (time.process_time() - start))


def library_camera(photograph: Photograph) -> sp.CameraModel:
    """The library's camera of a photograph."""
    K, D = photograph.K.ravel().tolist(), photograph.D.tolist()
    model = "plumb_bob" if len(D) <= 5 else "rational_polynomial"
    return sp.CameraModel.raw(sp.Calibration(photograph.width, photograph.height, K, D, model))


def _seater(folder: PhotographFolder, photograph: Photograph, parameters: dict[str, Any] | None) -> Detector:
    try:
        layout = sp.layout_of_equal_markers(folder.dictionary, 1.0)
        detector = sp.DockDetector(library_camera(photograph), layout, parameters)
    except (sp.ConfigurationError, sp.CalibrationError) as error:
        raise ParameterError(f"{photograph.path}: {error}") from error

    def detect(image: Image) -> list[Found]:
        return [
            Found(
                id=m.id,
                corners=m.corners,
                pose=m.hypotheses[0].pose,
                covariance=m.covariance,
                ambiguity=m.ambiguity,
                stage=getattr(m, "stage", ""),
            )
            for m in detector.detect(image).markers
        ]

    return detect


def _opencv(folder: PhotographFolder, photograph: Photograph, parameters: dict[str, Any] | None) -> Detector:
    """Debian's, its own defaults with sub-pixel corners, as aruco_ros and aruco_detect use it; one thread."""
    cv2.setNumThreads(1)
    family = marker_family(folder.dictionary)
    settings, dictionary = detector_parameters(cv2.aruco.CORNER_REFINE_SUBPIX), family.dictionary()
    settings.markerBorderBits = family.border

    def detect(image: Image) -> list[Found]:
        corners, ids, _ = cv2.aruco.detectMarkers(image, dictionary, parameters=settings)
        if ids is None:
            return []
        turns, places, _ = cv2.aruco.estimatePoseSingleMarkers(corners, 1.0, photograph.K, photograph.D)
        found = []
        for i, c, r, t in zip(ids.ravel(), corners, turns, places, strict=True):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(r)[0], t[0]
            found.append(Found(id=int(i), corners=np.asarray(c, dtype=float).reshape(4, 2), pose=pose))
        return found

    return detect
