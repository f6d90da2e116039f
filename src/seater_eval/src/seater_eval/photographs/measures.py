"""What one detector's finds in one photograph are worth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.perception.images.scenes import normal_error, normalised_error_squared, pose_error
from seater_eval.photographs.board import SQUARE, Board, MarkerTruth, leave_one_out
from seater_eval.photographs.branches import CERTAIN, WRONG_BRANCH, Branch
from seater_eval.photographs.detectors import Found
from seater_eval.photographs.truth import KnownMarker, Photograph

Array = NDArray[np.float64]
SAME_PLACE = 0.35  # [sides] of a find from the known centre; neighbours on a board are a whole side away


@dataclass(frozen=True, kw_only=True)
class Matched:
    """Known and found markers of one photograph."""

    found: dict[int, Found]
    missed: list[KnownMarker]
    false: list[Found]  # an id that is not there, or not at this place, or twice
    unlisted: list[Found] = field(default_factory=list)  # there, but not in truth.json; neither found nor false


def match(photograph: Photograph, found: list[Found]) -> Matched:
    """Each known marker gets the find of its id at its place."""
    known = {m.id: m for m in photograph.markers}
    right: dict[int, Found] = {}
    false = []
    for f in found:
        marker = known.get(f.id)
        off = math.inf if marker is None else float(np.linalg.norm(f.corners.mean(axis=0) - marker.center))
        if marker is None or off > SAME_PLACE * marker.side or f.id in right:
            false.append(f)
        else:
            right[f.id] = f
    return Matched(found=right, missed=[m for m in photograph.markers if m.id not in right], false=false)


@dataclass(frozen=True, kw_only=True)
class MarkerErrors:
    """One marker against the board's homography through the others."""

    id: int
    side: float  # [px]
    corners: tuple[float, ...]  # length of each corner's error [px]
    inwards: float  # mean component of it towards the centre [px]
    normal: float  # angle between the normals [rad]
    certain: bool
    nees: float | None  # of the pose, 6 degrees of freedom
    corner_nees: float | None  # of a projected corner, mean of four; 2 degrees of freedom
    stage: str

    @property
    def branch(self) -> Branch:
        return Branch(right=self.normal <= WRONG_BRANCH, certain=self.certain)

    @property
    def wrong_and_certain(self) -> bool:
        return self.branch.wrong_and_certain


def errors_on_board(board: Board, photograph: Photograph, found: dict[int, Found]) -> list[MarkerErrors]:
    """Of all markers that the others give a truth for. A detector without poses (`pose` None) has errors of corners."""
    corners = {i: f.corners for i, f in found.items()}
    errors = []
    for i, f in found.items():
        truth = leave_one_out(board, photograph, corners, i)
        if truth is not None:
            errors.append(_errors(photograph, f, truth))
    return errors


def _errors(photograph: Photograph, found: Found, truth: MarkerTruth) -> MarkerErrors:
    off = found.corners - truth.corners
    out = truth.corners - truth.corners.mean(axis=0)
    inwards = -float(np.mean(np.sum(off * out, axis=1) / np.linalg.norm(out, axis=1)))
    nees = corner_nees = None
    angle = 0.0
    if found.pose is not None:
        angle = normal_error(found.pose, truth.pose)
        if found.covariance is not None:
            nees = normalised_error_squared(pose_error(found.pose, truth.pose), found.covariance)
            corner_nees = _corner_nees(photograph, found.pose, found.covariance, truth.corners)
    return MarkerErrors(
        id=found.id,
        side=float(np.linalg.norm(truth.corners - np.roll(truth.corners, 1, axis=0), axis=1).mean()),
        corners=tuple(np.linalg.norm(off, axis=1).tolist()),
        inwards=inwards,
        normal=angle,
        certain=found.pose is not None and found.ambiguity < CERTAIN,
        nees=nees,
        corner_nees=corner_nees,
        stage=found.stage,
    )


def _corner_nees(photograph: Photograph, pose: Array, covariance: Array, corners: Array) -> float:
    """Mean of e' (J C J')^-1 e over the four corners; J: of the projected corner by the pose."""
    points = np.column_stack([SQUARE * [1.0, -1.0], np.zeros(4)])  # the marker's y goes up
    arms = points @ pose[:3, :3].T
    zero = np.zeros(3)

    def project(moved: Array) -> Array:
        return np.asarray(cv2.projectPoints(moved, zero, zero, photograph.K, photograph.D)[0].reshape(-1, 2))

    places = arms + pose[:3, 3]
    e = corners - project(places)
    step = 1e-6
    by_place = np.stack([(project(places + step * a) - project(places - step * a)) / (2 * step) for a in np.eye(3)], -1)
    values = []
    for k in range(4):
        x, y, z = arms[k]
        by_pose = np.hstack([np.eye(3), -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])])
        J = by_place[k] @ by_pose
        values.append(float(e[k] @ np.linalg.solve(J @ covariance @ J.T, e[k])))
    return float(np.mean(values))
