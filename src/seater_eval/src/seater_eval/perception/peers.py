"""Other people's marker detectors on the same images, with our conventions: corners in pixels whose centres are whole
numbers, poses T_optical_marker with x right, y up as the print is read, z out of the paper."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.marker_family import marker_family
from seater_eval.peers import catalogue
from seater_eval.peers.process import PeerProcess, peer_process
from seater_eval.run.silence import silence

Array = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Seen:
    """A marker as a detector reports it."""

    id: int
    corners: Array  # (4, 2) [px]
    pose: Array  # (4, 4)


Detector = Callable[[Image], list[Seen]]

PEERS = ("opencv_none", "opencv_default", "opencv_scaled", "opencv_apriltag", "pupil_apriltags")
LABELS = {
    "seater": "seater",
    "opencv_none": "OpenCV, corners as found",
    "opencv_default": "OpenCV default (aruco_ros, aruco_detect)",
    "opencv_scaled": "OpenCV, scaled sub-pixel window",
    "opencv_apriltag": "OpenCV, APRILTAG refinement",
    "pupil_apriltags": "pupil-apriltags (36h11)",
    "bound": "Cramér-Rao bound",
    "published_corners": "(the package's own corners)",
    **catalogue.PEERS,
}
APRILTAG_FAMILY, APRILTAG_DICTIONARY = "tag36h11", "DICT_APRILTAG_36h11"


def dictionary_of(name: str) -> str:
    """The dictionary of the images that a peer is shown."""
    return APRILTAG_DICTIONARY if name == "pupil_apriltags" else "DICT_4X4_50"


def make_peer(
    name: str, K: Array, size: float, dictionary: str = "DICT_4X4_50", folder: Path | None = None
) -> Detector:
    """A detector by its name in PEERS, or in seater_eval.peers with the `folder` that tools/make_peers.sh made; for
    prints of this side [m]. One thread. Raises KeyError for other names, PeerError."""
    cv2.setNumThreads(1)
    if folder is not None and name in catalogue.PEERS:
        return from_process(peer_process(folder, name, dictionary), K, size)
    if name == "pupil_apriltags":
        return _pupil_apriltags(K, size)
    return _opencv(name, K, size, dictionary)


def detector_parameters(refinement: int) -> cv2.aruco.DetectorParameters:
    """OpenCV's defaults with one refinement of the corners."""
    parameters = cv2.aruco.DetectorParameters_create()
    parameters.cornerRefinementMethod = refinement
    return parameters


def _opencv(name: str, K: Array, size: float, dictionary: str) -> Detector:
    method = {
        "opencv_none": cv2.aruco.CORNER_REFINE_NONE,
        "opencv_default": cv2.aruco.CORNER_REFINE_SUBPIX,  # half window 5, OpenCV's default
        "opencv_scaled": cv2.aruco.CORNER_REFINE_NONE,
        "opencv_apriltag": cv2.aruco.CORNER_REFINE_APRILTAG,
    }[name]
    parameters = detector_parameters(method)
    family = marker_family(dictionary)
    markers, cells = family.dictionary(), family.cells
    parameters.markerBorderBits = family.border
    distortion = np.zeros(5)

    def detect(image: Image) -> list[Seen]:
        corners, ids, _ = cv2.aruco.detectMarkers(image, markers, parameters=parameters)
        if ids is None:
            return []
        if name == "opencv_scaled":
            corners = [_scaled_sub_pixel(image, c, cells) for c in corners]
        if name == "opencv_apriltag":
            corners = [c - np.float32(0.5) for c in corners]  # this method counts from the image's corner
        turns, places, _ = cv2.aruco.estimatePoseSingleMarkers(corners, size, K, distortion)
        seen = []
        for i, r, t, c in zip(ids.ravel(), turns, places, corners, strict=True):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(r)[0], t[0]
            seen.append(Seen(int(i), np.asarray(c, dtype=float).reshape(4, 2), pose))
        return seen

    return detect


def _scaled_sub_pixel(image: Image, corners: NDArray[np.float32], cells: int) -> NDArray[np.float32]:
    """cornerSubPix with a half window of 0.4 cells, at least 2 px."""
    side = float(np.linalg.norm(corners[0] - np.roll(corners[0], 1, axis=0), axis=1).mean())
    half = max(2, min(15, round(0.4 * side / cells)))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    refined = cv2.cornerSubPix(image, corners.reshape(-1, 1, 2).copy(), (half, half), (-1, -1), criteria)
    return np.asarray(refined.reshape(1, 4, 2))


def _pupil_apriltags(K: Array, size: float) -> Detector:
    """AprilTag 3 at full resolution (quad_decimate 1): its most accurate setting, not its fastest."""
    from pupil_apriltags import Detector as AprilTagDetector

    class Kept(AprilTagDetector):
        """Never destroyed: its destructor frees the tag families and then writes into them (pupil-apriltags 1.0.4, seen
        with valgrind: quick_decode_uninit after tag36h11_destroy), which breaks the heap of the whole process later
        on."""

        def __del__(self) -> None:
            pass

    detector = Kept(families=APRILTAG_FAMILY, nthreads=1, quad_decimate=1.0)
    # It counts from the image's corner: everything is half a pixel larger, the principal point too.
    camera = (K[0, 0], K[1, 1], K[0, 2] + 0.5, K[1, 2] + 0.5)
    # Its y goes down and its z into the paper; OpenCV's dictionary has the tags turned by half a turn.
    to_ours = np.diag([-1.0, 1.0, -1.0])

    def detect(image: Image) -> list[Seen]:
        seen = []
        with silence():  # it reports on standard output poses with more than two minima
            tags = detector.detect(image, estimate_tag_pose=True, camera_params=camera, tag_size=size)
        for tag in tags:
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = tag.pose_R @ to_ours, tag.pose_t.ravel()
            seen.append(Seen(int(tag.tag_id), np.roll(tag.corners[::-1], 2, axis=0) - 0.5, pose))
        return seen

    return detect


def from_process(process: PeerProcess, K: Array, size: float) -> Detector:
    """Its corners, with poses by IPPE."""

    def detect(image: Image) -> list[Seen]:
        found = [Seen(i, corners, np.eye(4)) for i, corners in process.look(image).found]
        return [Seen(s.id, s.corners, best_of_ippe(s, K, size)) for s in found]

    return detect


def best_of_ippe(seen: Seen, K: Array, size: float) -> Array:
    """T_optical_marker of the smaller reprojection error of both solutions of IPPE (Collins and Bartoli, IJCV 2014)."""
    h = 0.5 * size
    points = np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])
    _, turns, places, _ = cv2.solvePnPGeneric(points, seen.corners, K, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = cv2.Rodrigues(turns[0])[0], places[0].ravel()
    return pose
