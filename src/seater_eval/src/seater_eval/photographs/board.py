"""A board as the truth of one of its markers: by the homography through its neighbours, leaving it out itself.

Only neighbours: paper is never quite flat, and published distortion never quite right, but both are smooth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.photographs.truth import Photograph

Array = NDArray[np.float64]
# Corners of a marker of side 1 about its centre, top left first, clockwise as the print is read; y down.
SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
NEIGHBOURS, FEWEST = 8, 5  # markers that the truth of one rests on
# [px] rms of the neighbours' own corners about their homography: above, the board is bent there and no truth. Corners
# of photographs are good to some 0.4 px.
FLAT = 1.0


@dataclass(frozen=True, kw_only=True)
class Board:
    """Where the corners of each marker are on the board, all counted in marker sides."""

    corners: dict[int, Array]  # id -> (4, 2)


def board_of(
    centers: dict[int, Array], seen: Sequence[tuple[Photograph, dict[int, Array]]], side: float | None
) -> Board | None:
    """The board of these centres; nothing when no photograph shows enough of it. How the markers are turned on it, and
    their side where it is not told, follow from what was `seen` (id -> corners (4, 2) [px]), over all photographs."""
    turns = [offsets for p, corners in seen for offsets in _offsets(centers, p, corners)]
    if not turns:
        return None
    # Each marker's corners about its centre are SQUARE times a matrix: a multiple of a rotation or reflection.
    matrix = np.median([np.linalg.lstsq(SQUARE, o, rcond=None)[0] for o in turns], axis=0)
    U, scale, Vt = np.linalg.svd(matrix)
    side = float(scale.mean()) if side is None else side
    upright = np.rint(U @ Vt)
    return Board(corners={i: at / side + SQUARE @ upright for i, at in centers.items()})


def _offsets(centers: dict[int, Array], photograph: Photograph, corners: dict[int, Array]) -> list[Array]:
    """Corners about their markers' centres on the board, by the homography of the centres."""
    ids = [i for i in corners if i in centers]
    if len(ids) <= FEWEST:
        return []
    middles = undistorted(photograph, np.array([_middle(corners[i]) for i in ids]))
    H, _ = cv2.findHomography(middles, np.array([centers[i] for i in ids]), cv2.RANSAC, 0.2)
    if H is None:
        return []
    on_board = cv2.perspectiveTransform(undistorted(photograph, np.concatenate([corners[i] for i in ids]))[None], H)[0]
    return [on_board[4 * k : 4 * k + 4] - centers[i] for k, i in enumerate(ids)]


def _middle(corners: Array) -> Array:
    """Where the diagonals meet: the centre of the square, whatever the perspective."""
    a, b, c, d = corners
    s = np.linalg.solve(np.column_stack([c - a, b - d]), b - a)
    return np.asarray(a + s[0] * (c - a))


def undistorted(photograph: Photograph, pixels: Array) -> Array:
    """(n, 2) [px] of a camera with the same K and no distortion."""
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-9)
    points = cv2.undistortPointsIter(pixels.reshape(-1, 1, 2), photograph.K, photograph.D, None, photograph.K, criteria)
    return np.asarray(points.reshape(-1, 2))


@dataclass(frozen=True, kw_only=True)
class MarkerTruth:
    """Of one marker, without its own corners."""

    corners: Array  # (4, 2) [px] in the photograph as it is
    pose: Array  # (4, 4) T_optical_marker, in marker sides


def leave_one_out(board: Board, photograph: Photograph, corners: dict[int, Array], id_: int) -> MarkerTruth | None:
    """The truth of marker `id_` by the homography through the `corners` (id -> (4, 2) [px]) of the NEIGHBOURS nearest
    on the board; nothing when they are too few or the board is not flat there."""
    here = board.corners.get(id_)
    others = [i for i in corners if i != id_ and i in board.corners]
    if here is None or len(others) < FEWEST:
        return None
    middle = here.mean(axis=0)
    others.sort(key=lambda i: float(np.linalg.norm(board.corners[i].mean(axis=0) - middle)))
    at = np.concatenate([board.corners[i] for i in others[:NEIGHBOURS]])
    pixels = undistorted(photograph, np.concatenate([corners[i] for i in others[:NEIGHBOURS]]))
    H, _ = cv2.findHomography(at, pixels)
    if H is None:
        return None
    off = cv2.perspectiveTransform(at[None], H)[0] - pixels
    if np.sqrt(np.mean(np.sum(off**2, axis=1))) > FLAT:
        return None
    seen = cv2.perspectiveTransform(here[None], H)[0]
    pose = _pose(photograph, at, pixels, here)
    return None if pose is None else MarkerTruth(corners=distorted(photograph, seen), pose=pose)


def distorted(photograph: Photograph, pixels: Array) -> Array:
    """(n, 2) [px]: the inverse of `undistorted`."""
    rays = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(photograph.K).T
    return np.asarray(cv2.projectPoints(rays, np.zeros(3), np.zeros(3), photograph.K, photograph.D)[0].reshape(-1, 2))


def _pose(photograph: Photograph, at: Array, pixels: Array, here: Array) -> Array | None:
    """T_optical_marker of the marker whose corners are `here` on the board: the board's pose, at the marker. `pixels`:
    undistorted."""
    points = np.column_stack([at, np.zeros(len(at))])
    found, turn, place = cv2.solvePnP(points, pixels, photograph.K, None, flags=cv2.SOLVEPNP_IPPE)
    if not found:
        return None
    turn, place = cv2.solvePnPRefineLM(points, pixels, photograph.K, None, turn, place)
    T_board_marker = np.eye(4)
    right, up = here[1] - here[0], here[0] - here[3]
    axes = np.zeros((3, 3))
    axes[:2, 0], axes[:2, 1] = right, up
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    T_board_marker[:3, :3], T_board_marker[:2, 3] = axes, here.mean(axis=0)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(turn)[0], place.ravel()
    return np.asarray(T @ T_board_marker)
