"""Markers that are there although truth.json does not list them: no detector had seen them when it was written.

Where a print's id has to be, its own board tells, or another photograph of the same board, by the homography through
the markers that the truth lists. No detector's corners enter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.photographs.board import undistorted
from seater_eval.photographs.detectors import Found
from seater_eval.photographs.measures import SAME_PLACE, Matched
from seater_eval.photographs.truth import Photograph, PhotographFolder

Array = NDArray[np.float64]
# Listed markers that a homography rests on (the nearest ones: boards are bent), and the part of them that has to lie on
# it: four always do.
FEWEST, MOST, AGREEING = 8, 12, 0.8
TOLERANCE = 4.0  # [px] centres are good to some 1 px, and twelve markers bent by less than that


def with_unlisted(folder: PhotographFolder, photograph: Photograph, matched: Matched) -> Matched:
    """The same, with false finds that stand where their id has to be counted apart."""
    known = {m.id for m in photograph.markers}
    there = [f for f in matched.false if f.id not in known and _stands_there(folder, photograph, f)]
    return replace(matched, false=[f for f in matched.false if all(f is not t for t in there)], unlisted=there)


def _stands_there(folder: PhotographFolder, photograph: Photograph, found: Found) -> bool:
    place = place_of(folder, photograph, found.id)
    if place is None:
        return False
    corners = undistorted(photograph, found.corners)
    side = float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).min())
    return float(np.linalg.norm(corners.mean(axis=0) - place)) < SAME_PLACE * side


def place_of(folder: PhotographFolder, photograph: Photograph, marker_id: int) -> Array | None:
    """(2,) centre in the photograph without its distortion [px], by the first source that shares enough markers with
    it, all on one plane; None when there is none."""
    listed = _centers(photograph)
    for source in _sources(folder, photograph):
        if marker_id not in source:
            continue
        both = sorted(listed.keys() & source.keys(), key=lambda i: float(np.linalg.norm(source[i] - source[marker_id])))
        if len(both) < FEWEST:
            continue
        pairs = np.array([source[i] for i in both[:MOST]]), np.array([listed[i] for i in both[:MOST]])
        H, on = cv2.findHomography(*pairs, cv2.RANSAC, TOLERANCE)
        if H is not None and on.mean() >= AGREEING:
            return np.asarray(cv2.perspectiveTransform(source[marker_id][None, None], H)[0, 0])
    return None


def _sources(folder: PhotographFolder, photograph: Photograph) -> Iterator[dict[int, Array]]:
    if folder.board:
        yield folder.board
    yield from (_centers(p) for p in folder.photographs if p is not photograph)


def _centers(photograph: Photograph) -> dict[int, Array]:
    centers = np.array([m.center for m in photograph.markers], dtype=float).reshape(-1, 2)
    if len(centers) == 0:
        return {}
    return {m.id: at for m, at in zip(photograph.markers, undistorted(photograph, centers), strict=True)}
