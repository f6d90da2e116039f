"""The AprilTag pictures of Debian's package visp-images-data: known poses, made by others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.perception import subject
from seater_eval.perception.degraded_camera import DegradedCamera
from seater_eval.perception.peers import make_peer

FOLDER = Path("/usr/share/visp-images-data/ViSP-images/AprilTag/benchmark/640x480")
FAMILIES = (("16_05", "DICT_APRILTAG_16h5", 6), ("25_09", "DICT_APRILTAG_25h9", 7), ("36_11", "DICT_APRILTAG_36h11", 8))
HALF_SIZE = (3, 4)  # these tags are half as large
CORNERS = "published_corners"
OPENCV = ("opencv_none", "opencv_default", "opencv_scaled", "opencv_apriltag")


def read_corners(path: Path) -> dict[int, NDArray[np.float64]]:
    """Id -> (4, 2) [px] in our convention, top left first, clockwise as the print is read. In the file: id, then four lines, in
    pixels that count from the picture's corner, anticlockwise, and of a print turned by half a turn."""
    numbers = path.read_text().split()
    tags = [numbers[i : i + 9] for i in range(0, len(numbers), 9)]
    return {int(tag[0]): np.array(tag[1:], dtype=float).reshape(4, 2)[[1, 0, 3, 2]] - 0.5 for tag in tags}


def position_from_corners(corners: NDArray[np.float64], camera: DegradedCamera, size: float) -> NDArray[np.float64]:
    """(3,) [m]: least squares on four corners, from the better solution of IPPE."""
    h = 0.5 * size
    points = np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])
    _, turn, place = cv2.solvePnP(points, corners, camera.K, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    return np.asarray(cv2.solvePnPRefineLM(points, corners, camera.K, None, turn, place)[1]).ravel()


def published_pictures(config: str | Path) -> dict[str, Any] | None:
    """Tags found and error of position [mm] of each method; None when the package is not installed. `published_corners`: the
    poses that the package's own corners give, which says how exact its poses are.

    Their pixels count from the picture's corner: the principal point (320, 240) is (319.5, 239.5) here, f = 700. A black
    square is 0.25 m x n / (n + 2) with n cells.
    """
    if not FOLDER.is_dir():
        return None
    camera = DegradedCamera(640, 480, 700.0, 0.0, 0.0, 0.0, 255.0, 255.0, 1.0)
    parameters = subject.perception_parameters(config)
    errors: dict[str, list[float]] = {name: [] for name in ("seater", *OPENCV, CORNERS)}
    for family, dictionary, cells in FAMILIES:
        picture = cv2.imread(str(FOLDER / f"tag{family}_640x480.png"), cv2.IMREAD_GRAYSCALE)
        corners = read_corners(FOLDER / f"corners_tag{family}.txt")
        for half in (False, True):
            size = 0.25 * cells / (cells + 2.0) * (0.5 if half else 1.0)
            layout = subject.layout(size, False, dictionary=dictionary)
            detector = subject.sp.DockDetector(subject.camera_model(camera), layout, parameters)
            for tag in (t for t in corners if (t in HALF_SIZE) == half):
                off = position_from_corners(corners[tag], camera, size) - _truth(tag)
                errors[CORNERS].append(1e3 * float(np.linalg.norm(off)))
            for name in ("seater", *OPENCV):
                found = errors[name]
                detect = subject.as_peer(detector) if name == "seater" else make_peer(name, camera.K, size, dictionary)
                for seen in detect(picture):
                    if 0 <= seen.id < 5 and (seen.id in HALF_SIZE) == half:
                        found.append(1e3 * float(np.linalg.norm(seen.pose[:3, 3] - _truth(seen.id))))
    result: dict[str, Any] = {"tags": 5 * len(FAMILIES)}
    for name, found in errors.items():
        worst = max(found) if found else None
        result[name] = {"found": len(found), "median_mm": float(np.median(found)) if found else None, "worst_mm": worst}
    for key in ("median_mm", "worst_mm"):  # the best of the refinements, for each figure by itself
        best = [result[name][key] for name in OPENCV if result[name]["found"] == result["tags"]]
        result[f"best_opencv_{key}"] = min(best) if best else None
    return result


def _truth(tag: int) -> NDArray[np.float64]:
    """(3,) [m]."""
    return np.asarray(np.loadtxt(FOLDER / f"cMo_{tag}.txt")[:3, 3])
