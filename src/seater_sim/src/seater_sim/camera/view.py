"""From planar polygons in the world to polygons in the image: clipping and projection for one camera pose."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_sim.world.scene import Face

Array = NDArray[np.float64]

NEAR = 0.05  # [m] nearer things are not drawn
SHIFT = 4  # OpenCV draws with 1 / 2^SHIFT px
EDGE_PIECES = 8  # a straight edge becomes so many pieces when the lens bends it


class Frustum:
    """The part of space that can be in the image: half-spaces a . p + d >= 0 in the optical frame."""

    def __init__(self, model: CameraModel) -> None:
        self.model = model
        # The widest rays of the image's rim, and a little more so that the cut edges stay outside.
        rays = model.rays(margin=2) if model.distorted else _corner_rays(model)
        low, high = rays.reshape(-1, 2).min(axis=0) - 0.02, rays.reshape(-1, 2).max(axis=0) + 0.02
        self._normals = np.array(
            [[1.0, 0.0, -low[0]], [-1.0, 0.0, high[0]], [0.0, 1.0, -low[1]], [0.0, -1.0, high[1]], [0.0, 0.0, 1.0]]
        )
        self._offsets = np.array([0.0, 0.0, 0.0, 0.0, -NEAR])

    def distances(self, points: Array) -> Array:
        """Of points (n, 3) [m] from the five planes, (n, 5); negative outside."""
        return np.asarray(points @ self._normals.T + self._offsets)

    def clip(self, points: Array) -> Array | None:
        """The visible part of a convex polygon (n, 3) [m] in the optical frame; None when there is none."""
        distances = self.distances(points)
        if np.all(distances >= 0.0):
            return points
        if np.any(np.all(distances < 0.0, axis=0)):
            return None
        corners = points.tolist()
        for plane in np.flatnonzero(np.any(distances < 0.0, axis=0)):
            corners = _cut(corners, self._normals[plane].tolist(), float(self._offsets[plane]))
            if len(corners) < 3:
                return None
        return np.array(corners)

    def outline(self, points: Array) -> Array | None:
        """Pixels (m, 2) along the visible part of a convex polygon; None when nothing is visible."""
        visible = self.clip(points)
        return None if visible is None else self.project(visible)

    def project(self, visible: Array) -> Array:
        """Pixels (m, 2) along a polygon (n, 3) [m] that is wholly visible."""
        if self.model.distorted:
            t = np.arange(EDGE_PIECES)[None, :, None] / EDGE_PIECES
            following = np.roll(visible, -1, axis=0)
            visible = np.asarray(visible[:, None, :] * (1.0 - t) + following[:, None, :] * t, dtype=float).reshape(
                -1, 3
            )
        return self.model.project(visible)


class FaceSet:
    """Faces that are drawn in their order; what all have in common is computed at once."""

    def __init__(self, faces: list[Face]) -> None:
        """`faces`: in the dock frame; at least one."""
        self._colours = [face.colour for face in faces]
        self._normals = np.array([face.normal for face in faces])
        self._points = np.concatenate([face.points for face in faces])
        self._origins = np.array([face.points[0] for face in faces])
        self._ends = np.cumsum([len(face.points) for face in faces])
        self._starts = self._ends - [len(face.points) for face in faces]

    def draw(self, image: NDArray[np.uint8], frustum: Frustum, T_optical_dock: Array) -> None:
        """Draw the faces that look towards the camera, in rgb or their luminance."""
        T = T_optical_dock
        camera = -T[:3, :3].T @ T[:3, 3]
        points = self._points @ T[:3, :3].T + T[:3, 3]
        inside = frustum.distances(points) >= 0.0
        whole = np.logical_and.reduceat(inside, self._starts).all(axis=1)
        partly = np.logical_or.reduceat(inside, self._starts).all(axis=1)
        partly &= np.sum(self._normals * (camera - self._origins), axis=1) > 0.0
        for i in np.flatnonzero(partly):
            polygon = points[self._starts[i] : self._ends[i]]
            outline = frustum.project(polygon) if whole[i] else frustum.outline(polygon)
            if outline is not None:
                fill(image, outline, _paint(self._colours[i], image.ndim == 3))


def _paint(colour: tuple[float, float, float], rgb: bool) -> tuple[float, ...]:
    """The colour for OpenCV: rgb, or its luminance (BT.601)."""
    r, g, b = colour
    return colour if rgb else (0.299 * r + 0.587 * g + 0.114 * b,)


def fill(image: NDArray[np.uint8], outline: Array, colour: tuple[float, ...]) -> None:
    """Draw a filled polygon of pixels (m, 2), edges smoothed."""
    points = np.rint(outline * (1 << SHIFT)).astype(np.int32)
    cv2.fillPoly(image, [points], colour, cv2.LINE_AA, SHIFT)


def bounding_box(outline: Array, model: CameraModel, margin: float) -> tuple[int, int, int, int] | None:
    """x0, y0, x1, y1 (x1, y1 excluded) of the pixels within `margin` px of the outline; None outside the image."""
    low = np.floor(outline.min(axis=0) - margin + 0.5).astype(int)
    high = np.ceil(outline.max(axis=0) + margin + 0.5).astype(int)
    x0, y0 = max(int(low[0]), 0), max(int(low[1]), 0)
    x1, y1 = min(int(high[0]), model.width), min(int(high[1]), model.height)
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def _cut(points: list[list[float]], normal: list[float], offset: float) -> list[list[float]]:
    """The part of a convex polygon on the positive side of one plane (Sutherland and Hodgman, 1974)."""
    distances = [p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2] + offset for p in points]
    kept = []
    for i, point in enumerate(points):
        here, there = distances[i - 1], distances[i]
        if (here < 0.0) != (there < 0.0):
            t = here / (here - there)
            kept.append([a + t * (b - a) for a, b in zip(points[i - 1], point, strict=True)])
        if there >= 0.0:
            kept.append(point)
    return kept


def _corner_rays(model: CameraModel) -> Array:
    corners = np.array([[x, y, 1.0] for x in (0, model.width) for y in (0, model.height)])
    rays = np.linalg.solve(model.K, corners.T).T
    return rays[:, :2] / rays[:, 2:]
