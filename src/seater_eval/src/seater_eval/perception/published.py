"""The AprilTag pictures of Debian's package visp-images-data: known poses, made by others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from seater_eval.perception import subject
from seater_eval.perception.degraded_camera import DegradedCamera
from seater_eval.perception.peers import make_peer

FOLDER = Path("/usr/share/visp-images-data/ViSP-images/AprilTag/benchmark/640x480")
FAMILIES = (("16_05", "DICT_APRILTAG_16h5", 6), ("25_09", "DICT_APRILTAG_25h9", 7), ("36_11", "DICT_APRILTAG_36h11", 8))
HALF_SIZE = (3, 4)  # these tags are half as large
OPENCV = ("opencv_none", "opencv_default", "opencv_scaled", "opencv_apriltag")


def published_pictures(config: str | Path) -> dict[str, Any] | None:
    """Tags found and error of position [mm] of each method; None when the package is not installed.

    Their pixels count from the picture's corner: the principal point (320, 240) is (319.5, 239.5) here, f = 700. A black
    square is 0.25 m x n / (n + 2) with n cells.
    """
    if not FOLDER.is_dir():
        return None
    camera = DegradedCamera(640, 480, 700.0, 0.0, 0.0, 0.0, 255.0, 255.0, 1.0)
    parameters = subject.perception_parameters(config)
    errors: dict[str, list[float]] = {name: [] for name in ("seater", *OPENCV)}
    for family, dictionary, cells in FAMILIES:
        picture = cv2.imread(str(FOLDER / f"tag{family}_640x480.png"), cv2.IMREAD_GRAYSCALE)
        for half in (False, True):
            size = 0.25 * cells / (cells + 2.0) * (0.5 if half else 1.0)
            layout = subject.layout(size, False, dictionary=dictionary)
            detector = subject.sp.DockDetector(subject.camera_model(camera), layout, parameters)
            for name, found in errors.items():
                detect = subject.as_peer(detector) if name == "seater" else make_peer(name, camera.K, size, dictionary)
                for seen in detect(picture):
                    if 0 <= seen.id < 5 and (seen.id in HALF_SIZE) == half:
                        truth = np.loadtxt(FOLDER / f"cMo_{seen.id}.txt")
                        found.append(1e3 * float(np.linalg.norm(seen.pose[:3, 3] - truth[:3, 3])))
    result: dict[str, Any] = {"tags": 5 * len(FAMILIES)}
    for name, found in errors.items():
        worst = max(found) if found else None
        result[name] = {"found": len(found), "median_mm": float(np.median(found)) if found else None, "worst_mm": worst}
    for key in ("median_mm", "worst_mm"):  # the best of the refinements, for each figure by itself
        best = [result[name][key] for name in OPENCV if result[name]["found"] == result["tags"]]
        result[f"best_opencv_{key}"] = min(best) if best else None
    return result
