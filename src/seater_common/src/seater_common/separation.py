"""Lines that separate the chair's footprint from convex polygons: what keeps a plan clear of obstacles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, QhullError

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Lines:
    """For each of n poses and m polygons the line with the largest distance between the footprint and the polygon.

    The polygon lies in normal . p <= offset, so a footprint whose corners V have normal . V >= offset is clear of it.
    """

    normals: Array  # (n, m, 2), unit vectors from the polygon towards the chair
    offsets: Array  # (n, m) [m]
    distances: Array  # (n, m) [m], signed; negative: they overlap, and the line is that of the shortest way out


def footprints(corners: ArrayLike, poses: ArrayLike) -> Array:
    """Corners of the footprint (4, 2), given in base_link, at the poses (n, >= 3): shape (n, 4, 2)."""
    corners, poses = np.asarray(corners, float), np.asarray(poses, float)
    c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x = poses[:, 0, None] + c * corners[:, 0] - s * corners[:, 1]
    y = poses[:, 1, None] + s * corners[:, 0] + c * corners[:, 1]
    return np.stack([x, y], axis=2)


def separating_lines(shapes: Array, polygons: list[Array]) -> Lines:
    """Between the footprints `shapes` (n, 4, 2) and convex polygons, (k, 2) each, both anticlockwise.

    The best normal is across an edge of one or, where two corners face each other, along the line between these.
    """
    found = [_best(shapes, polygon) for polygon in polygons]
    if not found:
        nothing = np.zeros((len(shapes), 0))
        return Lines(np.zeros((len(shapes), 0, 2)), nothing, nothing)
    normals, offsets, distances = (np.stack([one[i] for one in found], axis=1) for i in range(3))
    return Lines(normals, offsets, distances)


def edge_distances(shapes: Array, polygon: Array) -> Array:
    """(n,) largest signed distance [m] across an edge of either: distance, or less where corners face each other."""
    theirs = -outward_normals(polygon[None])[0]  # (k, 2)
    ahead = np.min(shapes @ -theirs.T, axis=1) + np.min(polygon @ theirs.T, axis=0)
    ours = outward_normals(shapes)
    reach = np.sum(ours * shapes, axis=2)
    behind = np.min(ours @ polygon.T, axis=2) - reach
    return np.maximum(np.max(ahead, axis=1), np.max(behind, axis=1))


def outward_normals(shapes: Array) -> Array:
    """(n, k, 2) unit normals of the edges of the anticlockwise polygons `shapes` (n, k, 2)."""
    edges = np.roll(shapes, -1, axis=1) - shapes
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=2)
    return np.asarray(normals / np.linalg.norm(normals, axis=2, keepdims=True))


def _best(shapes: Array, polygon: Array) -> tuple[Array, Array, Array]:
    """Normal (n, 2), offset (n,), distance (n,) of the line with the largest distance between shape and polygon."""
    count = len(shapes)
    across = np.broadcast_to(outward_normals(polygon[None]), (count, len(polygon), 2))
    between = (shapes[:, :, None, :] - polygon).reshape(count, -1, 2)
    length = np.linalg.norm(between, axis=2, keepdims=True)
    normals = np.concatenate([across, -outward_normals(shapes), between / np.maximum(length, 1e-9)], axis=1)
    offsets = np.max(normals @ polygon.T, axis=2)
    distances = np.min(normals @ shapes.transpose(0, 2, 1), axis=2) - offsets
    best, rows = np.argmax(distances, axis=1), np.arange(count)
    return normals[rows, best], offsets[rows, best], distances[rows, best]


def nearest(lines: Lines, count: int) -> Lines:
    """Of each pose the `count` lines with the smallest distances."""
    order: Indices = np.argsort(lines.distances, axis=1, kind="stable")[:, :count]
    rows = np.arange(len(order))[:, None]
    return Lines(lines.normals[rows, order], lines.offsets[rows, order], lines.distances[rows, order])


def convex_outline(points: ArrayLike) -> Array:
    """The convex hull of points (n, 2), anticlockwise from its leftmost corner, without points on its edges.

    Raises:
        ValueError: not finite, fewer than three points, or all of them on one line.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3 or not np.all(np.isfinite(points)):
        raise ValueError("an obstacle must be at least three finite points (x, y)")
    try:
        hull = points[ConvexHull(points).vertices]
    except QhullError as error:
        raise ValueError("an obstacle must have an area: its points lie on one line") from error
    return np.roll(hull, -int(np.lexsort((hull[:, 1], hull[:, 0]))[0]), axis=0)
