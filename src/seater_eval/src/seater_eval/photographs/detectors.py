"""Detectors of photographs, one interface: what they find in one, and the processor time that they take."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_eval.peers.process import peer_process
from seater_eval.perception.peers import detector_parameters
from seater_eval.photographs.truth import Photograph, PhotographFolder

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
# Debian's OpenCV with its default corners, as it is used; without refinement and poses, as the measure of time.
SEATER, OPENCV, PLAIN = "seater", "opencv_default", "opencv_none"
CORNERS = "seater_corners"  # ours, with poses of the corners alone
SQUARE_3D = np.array([[-0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [-0.5, -0.5, 0.0]])  # in marker sides


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


Detector = Callable[[Image], Detection]
Look = Callable[[Image], list[Found]]


def make_detector(
    name: str,
    folder: PhotographFolder,
    photograph: Photograph,
    parameters: dict[str, Any] | None,
    peers: Path | None = None,
) -> Detector:
    """`parameters`: config/perception.yaml as a mapping, for ours; `peers`: what tools/make_peers.sh made, for the
    names of seater_eval.peers. Raises ParameterError, PeerError."""
    if name == SEATER:
        return _timed(_seater(folder, photograph, parameters))
    if name == CORNERS:
        return _timed(_seater(folder, photograph, {**(parameters or {}), "refinement": "corners_visp"}))
    if name in (OPENCV, PLAIN):
        return _timed(_opencv(folder, photograph, name == OPENCV))
    assert peers is not None
    return _peer(peers, name, folder, photograph)


def _timed(look: Look) -> Detector:
    """Of a detector in this process."""

    def detect(image: Image) -> Detection:
        start = time.process_time()
        found = look(image)
        return Detection(found=found, milliseconds=1e3 * (time.process_time() - start))

    return detect


def library_camera(photograph: Photograph) -> sp.CameraModel:
    """The library's camera of a photograph."""
    K, D = photograph.K.ravel().tolist(), photograph.D.tolist()
    model = "plumb_bob" if len(D) <= 5 else "rational_polynomial"
    return sp.CameraModel.raw(sp.Calibration(photograph.width, photograph.height, K, D, model))


def _seater(folder: PhotographFolder, photograph: Photograph, parameters: dict[str, Any] | None) -> Look:
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


def _peer(peers: Path, name: str, folder: PhotographFolder, photograph: Photograph) -> Detector:
    """Poses by IPPE on its corners: none of the peers knows how uncertain its own are."""
    process = peer_process(peers, name, folder.dictionary)

    def detect(image: Image) -> Detection:
        answer = process.look(image)
        found = [Found(id=i, corners=c, pose=_ippe(c, photograph)) for i, c in answer.found]
        return Detection(found=found, milliseconds=answer.milliseconds)

    return detect


def _ippe(corners: Array, photograph: Photograph) -> Array | None:
    """T_optical_marker [marker sides] of the smaller reprojection error of both solutions (Collins and Bartoli, IJCV
    2014)."""
    flags = cv2.SOLVEPNP_IPPE_SQUARE
    count, turns, places, _ = cv2.solvePnPGeneric(SQUARE_3D, corners, photograph.K, photograph.D, flags=flags)
    if count == 0 or not np.isfinite(turns[0]).all():
        return None
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turns[0])[0], places[0].ravel()
    return pose


def _opencv(folder: PhotographFolder, photograph: Photograph, refined: bool) -> Look:
    """Debian's, its own defaults; `refined`: sub-pixel corners and poses, as aruco_ros and aruco_detect use it. One
    thread."""
    cv2.setNumThreads(1)
    family = marker_family(folder.dictionary)
    method = cv2.aruco.CORNER_REFINE_SUBPIX if refined else cv2.aruco.CORNER_REFINE_NONE
    settings, dictionary = detector_parameters(method), family.dictionary()
    settings.markerBorderBits = family.border

    def detect(image: Image) -> list[Found]:
        corners, ids, _ = cv2.aruco.detectMarkers(image, dictionary, parameters=settings)
        if ids is None:
            return []
        if not refined:
            pairs = zip(ids.ravel(), corners, strict=True)
            return [Found(id=int(i), corners=c.reshape(4, 2).astype(float)) for i, c in pairs]
        turns, places, _ = cv2.aruco.estimatePoseSingleMarkers(corners, 1.0, photograph.K, photograph.D)
        found = []
        for i, c, r, t in zip(ids.ravel(), corners, turns, places, strict=True):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(r)[0], t[0]
            found.append(Found(id=int(i), corners=np.asarray(c, dtype=float).reshape(4, 2), pose=pose))
        return found

    return detect
