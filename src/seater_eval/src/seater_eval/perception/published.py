"""The AprilTag images of Debian's package visp-images-data: known poses, made by others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.perception import subject
from seater_eval.perception.images.degraded_camera import DegradedCamera
from seater_eval.perception.peers import make_peer

FOLDER = Path("/usr/share/visp-images-data/ViSP-images/AprilTag/benchmark/640x480")
FAMILIES = (("16_05", "DICT_APRILTAG_16h5", 6), ("25_09", "DICT_APRILTAG_25h9", 7), ("36_11", "DICT_APRILTAG_36h11", 8))
HALF_SIZE = (3, 4)  # these tags are half as large
CORNERS = "published_corners"
# Their pixels count from the image's corner: the principal point (320, 240) is (319.5, 239.5) here.
CAMERA = DegradedCamera(640, 480, 700.0, 0.0, 0.0, 0.0, 255.0, 255.0, 1.0)
OPENCV = ("opencv_none", "opencv_default", "opencv_scaled", "opencv_apriltag")


def read_corners(path: Path) -> dict[int, NDArray[np.float64]]:
    """Id -> (4, 2) [px] in our convention, top left first, clockwise as the print is read. In the file: id, then four
    lines, in pixels that count from the image's corner, anticlockwise, and of a print turned by half a turn."""
    numbers = path.read_text().split()
    tags = [numbers[i : i + 9] for i in range(0, len(numbers), 9)]
    return {int(tag[0]): np.array(tag[1:], dtype=float).reshape(4, 2)[[1, 0, 3, 2]] - 0.5 for tag in tags}


def position_from_corners(corners: NDArray[np.float64], camera: DegradedCamera, size: float) -> NDArray[np.float64]:
    """(3,) [m]: least squares on four corners, from the better solution of IPPE."""
    points = _square(size)
    _, turn, place = cv2.solvePnP(points, corners, camera.K, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)
    return np.asarray(cv2.solvePnPRefineLM(points, corners, camera.K, None, turn, place)[1]).ravel()


def common_positions() -> dict[int, NDArray[np.float64]]:
    """Tag id -> (3,) [m]: the pose that the package's corners of all three images together give. In all of them a tag
    has one pose, so that this says what the images show where the package's own poses deviate from it (by up to 0.4
    px)."""
    points: dict[int, list[Any]] = {}
    seen: dict[int, list[Any]] = {}
    for family, _, cells in FAMILIES:
        for tag, corners in read_corners(FOLDER / f"corners_tag{family}.txt").items():
            points.setdefault(tag, []).append(_square(_size(cells, tag in HALF_SIZE)))
            seen.setdefault(tag, []).append(corners)
    positions = {}
    for tag in points:
        start = cv2.solvePnP(points[tag][0], seen[tag][0], CAMERA.K, None, flags=cv2.SOLVEPNP_IPPE_SQUARE)[1:]
        every = np.concatenate(points[tag]), np.concatenate(seen[tag])
        positions[tag] = np.asarray(cv2.solvePnPRefineLM(*every, CAMERA.K, None, *start)[1]).ravel()
    return positions


def published_images(config: str | Path) -> dict[str, Any] | None:
    """Tags found, errors of position [mm] of each method, and the same against common_positions; None when the package
    is not installed. `published_corners`: the poses that the package's own corners give, which says how exact its poses
    are."""
    if not FOLDER.is_dir():
        return None
    parameters = subject.perception_parameters(config)
    seen: dict[str, list[tuple[int, NDArray[np.float64]]]] = {name: [] for name in ("seater", *OPENCV, CORNERS)}
    for family, dictionary, cells in FAMILIES:
        image = cv2.imread(str(FOLDER / f"tag{family}_640x480.png"), cv2.IMREAD_GRAYSCALE)
        corners = read_corners(FOLDER / f"corners_tag{family}.txt")
        for half in (False, True):
            size = _size(cells, half)
            layout = subject.layout(size, False, dictionary=dictionary)
            detector = subject.sp.DockDetector(subject.camera_model(CAMERA), layout, parameters)
            for tag in (t for t in corners if (t in HALF_SIZE) == half):
                seen[CORNERS].append((tag, position_from_corners(corners[tag], CAMERA, size)))
            for name in ("seater", *OPENCV):
                detect = subject.as_peer(detector) if name == "seater" else make_peer(name, CAMERA.K, size, dictionary)
                found = [s for s in detect(image) if 0 <= s.id < 5 and (s.id in HALF_SIZE) == half]
                seen[name] += [(s.id, s.pose[:3, 3]) for s in found]
    common = common_positions()
    result: dict[str, Any] = {"tags": 5 * len(FAMILIES)}
    for name, positions in seen.items():
        errors = [1e3 * float(np.linalg.norm(position - _truth(tag))) for tag, position in positions]
        others = [1e3 * float(np.linalg.norm(position - common[tag])) for tag, position in positions]
        result[name] = {"found": len(errors), **_median_worst("", errors), **_median_worst("from_corners_", others)}
    for key in ("median_mm", "worst_mm"):  # the best of the refinements, for each statistic by itself
        best = [result[name][key] for name in OPENCV if result[name]["found"] == result["tags"]]
        result[f"best_opencv_{key}"] = min(best) if best else None
    return result


def _median_worst(prefix: str, errors: list[float]) -> dict[str, float | None]:
    median, worst = (float(np.median(errors)), max(errors)) if errors else (None, None)
    return {f"{prefix}median_mm": median, f"{prefix}worst_mm": worst}


def _size(cells: int, half: bool) -> float:
    """Side of the black square [m]: the print with its white margin of one cell is 0.25 m, or half of that."""
    return 0.25 * cells / (cells + 2.0) * (0.5 if half else 1.0)


def _square(size: float) -> NDArray[np.float64]:
    h = 0.5 * size
    return np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])


def _truth(tag: int) -> NDArray[np.float64]:
    """(3,) [m]."""
    return np.asarray(np.loadtxt(FOLDER / f"cMo_{tag}.txt")[:3, 3])
