"""One detector from PyPI, serving images: run by the interpreter of tools/make_peers.sh, without this project.

    python3 -I worker.py NAME DICTIONARY

It reads images from standard input: a line "HEIGHT WIDTH", then the grey levels. It answers each with a line of JSON:
{"found": [[id, [[u, v] x 4]], ...], "milliseconds": of processor time, all threads}. Before the first image, one line:
{"fault": why it cannot work, or ""}. Corners: top left first, clockwise as the print is read, in pixels whose centres
are whole numbers. One thread.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

Detect = Callable[[Any], list[tuple[int, Any]]]
HALF_PIXEL = 0.5  # of those that count from the image's corner
_KEPT: list[Any] = []  # never destroyed: see seater_eval.perception.peers


def locus(profile: str) -> Callable[[str], Detect]:
    def make(dictionary: str) -> Detect:
        package: Any = importlib.import_module("locus")  # by name: no dependency of the package
        family = dictionary.removeprefix("DICT_")
        names = {"APRILTAG_36h11": "AprilTag36h11", "APRILTAG_16h5": "AprilTag16h5", "ARUCO_MIP_36h12": "ArUcoMip36h12"}
        name = names.get(family, "ArUco" + family.lower())
        detector = package.Detector(profile=profile, threads=1, families=[getattr(package.TagFamily, name)])

        def detect(image: Any) -> list[tuple[int, Any]]:
            batch = detector.detect(image)
            return [(int(i), c - HALF_PIXEL) for i, c in zip(batch.ids, batch.corners, strict=True)]

        return detect

    return make


def rapidtag(dictionary: str) -> Detect:
    package: Any = importlib.import_module("rapidtag")
    parameters = package.DetectorParameters()
    parameters.corner_refinement_method = package.CORNER_REFINE_SUBPIX
    # As OpenCV, which ignores it unless asked for its fast search; rapidtag 0.1.12 drops all smaller markers.
    parameters.min_side_length_canonical_img = 0

    def detect(image: Any) -> list[tuple[int, Any]]:
        corners, ids = package.detect_markers(image, dictionary, parameters)
        return [(int(i), np.asarray(c)) for i, c in zip(ids, corners, strict=True)]

    return detect


def opencv(refinement: str, offset: float) -> Callable[[str], Detect]:
    def make(dictionary: str) -> Detect:
        import cv2

        cv2.setNumThreads(1)
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = getattr(cv2.aruco, refinement)
        family = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
        detector = cv2.aruco.ArucoDetector(family, parameters)

        def detect(image: Any) -> list[tuple[int, Any]]:
            corners, ids, _ = detector.detectMarkers(image)
            found = [] if ids is None else ids.ravel()
            return [(int(i), c.reshape(4, 2) - offset) for i, c in zip(found, corners, strict=True)]

        return detect

    return make


def apriltag(dictionary: str) -> Detect:
    from pupil_apriltags import Detector

    families = "tag" + dictionary.removeprefix("DICT_APRILTAG_")
    detector = Detector(families=families, nthreads=1, quad_decimate=1.0)
    _KEPT.append(detector)

    def detect(image: Any) -> list[tuple[int, Any]]:
        # Its corners run anticlockwise; OpenCV's dictionary has the tags turned by half a turn.
        return [(int(t.tag_id), np.roll(t.corners[::-1], 2, axis=0) - HALF_PIXEL) for t in detector.detect(image)]

    return detect


MAKERS: dict[str, Callable[[str], Detect]] = {
    "locus": locus("standard"),
    "locus_grid": locus("grid"),
    "rapidtag": rapidtag,
    "opencv5": opencv("CORNER_REFINE_SUBPIX", 0.0),
    "opencv5_apriltag": opencv("CORNER_REFINE_APRILTAG", HALF_PIXEL),
    "apriltag": apriltag,
}


def main() -> None:
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print is no answer

    def answer(what: dict[str, Any]) -> None:
        print(json.dumps(what), file=answers, flush=True)

    name, dictionary = sys.argv[1:]
    try:
        detect = MAKERS[name](dictionary)
    except Exception as error:  # whatever a foreign package raises
        return answer({"fault": f"{type(error).__name__}: {error}"})
    answer({"fault": ""})
    while line := sys.stdin.buffer.readline():
        height, width = map(int, line.split())
        image = np.frombuffer(sys.stdin.buffer.read(height * width), np.uint8).reshape(height, width).copy()
        start = time.process_time()
        found = detect(image)
        taken = 1e3 * (time.process_time() - start)
        answer({"found": [[i, np.asarray(c, dtype=float).tolist()] for i, c in found], "milliseconds": taken})
    return None


if __name__ == "__main__":
    os.environ["RAYON_NUM_THREADS"] = "1"  # before locus and rapidtag are loaded
    main()
    os._exit(0)  # without any destructor
