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
    shapes = np.empty((len(poses), len(corners), 2))
    shapes[:, :, 0] = poses[:, 0, None] + c * corners[:, 0] - s * corners[:, 1]
    shapes[:, :, 1] = poses[:, 1, None] + s * corners[:, 0] + c * corners[:, 1]
    return shapes


def separating_lines(shapes: Array, polygons: list[Array]) -> Lines:
    """Between the footprints `shapes` (n, 4, 2) and convex polygons, (k, 2) each, both anticlockwise.

    The best normal is across an edge of one or, where two corners face each other, along the line between these.
    """
    n, m, theirs = len(shapes), len(polygons), -outward_normals(shapes)
    lines = Lines(np.empty((n, m, 2)), np.empty((n, m)), np.empty((n, m)))
    for i, polygon in enumerate(polygons):
        lines.normals[:, i], lines.offsets[:, i], lines.distances[:, i] = _best(shapes, theirs, polygon)
    return lines


def edge_distances(shapes: Array, polygon: Array) -> Array:
    """(n,) largest signed distance [m] across an edge of either: distance, or less where corners face each other."""
    theirs = -outward_normals(polygon[None])[0]  # (k, 2)
    ahead = (shapes @ -theirs.T).min(axis=1) + (polygon @ theirs.T).min(axis=0)
    ours = outward_normals(shapes)
    reach = ours[:, :, 0] * shapes[:, :, 0] + ours[:, :, 1] * shapes[:, :, 1]
    behind = _over_last(np.minimum, ours @ polygon.T) - reach
    return np.maximum(ahead.max(axis=1), behind.max(axis=1))


def outward_normals(shapes: Array) -> Array:
    """(n, k, 2) unit normals of the edges of the anticlockwise polygons `shapes` (n, k, 2)."""
    normals = np.empty_like(shapes)
    normals[:, :-1, 0], normals[:, -1, 0] = shapes[:, 1:, 1] - shapes[:, :-1, 1], shapes[:, 0, 1] - shapes[:, -1, 1]
    normals[:, :-1, 1], normals[:, -1, 1] = shapes[:, :-1, 0] - shapes[:, 1:, 0], shapes[:, -1, 0] - shapes[:, 0, 0]
    normals /= _length(normals)[:, :, None]
    return normals


def _best(shapes: Array, inward: Array, polygon: Array) -> tuple[Array, Array, Array]:
    """Normal (n, 2), offset (n,), distance (n,) of the line with the largest distance between shape and polygon;
    `inward`: the shapes' normals, to the inside."""
    n, k, own = len(shapes), len(polygon), len(polygon) + shapes.shape[1]
    between = (shapes[:, :, None, :] - polygon).reshape(n, -1, 2)
    normals = np.empty((n, own + between.shape[1], 2))
    normals[:, :k], normals[:, k:own] = outward_normals(polygon[None]), inward
    np.divide(between, np.maximum(_length(between), 1e-9)[:, :, None], out=normals[:, own:])
    offsets = _over_last(np.maximum, normals @ polygon.T)
    distances = _over_last(np.minimum, normals @ shapes.transpose(0, 2, 1)) - offsets
    best, rows = distances.argmax(axis=1), np.arange(n)
    return normals[rows, best], offsets[rows, best], distances[rows, best]


def _over_last(reduction: np.ufunc, values: Array) -> Array:
    """The reduction of values (n, m, k) over k, which is short: NumPy is five times quicker along the first axis."""
    return np.asarray(reduction.reduce(values.transpose(2, 0, 1).copy()))


def _length(vectors: Array) -> Array:
    """(n, k) of vectors (n, k, 2). In a control cycle twice as quick as a norm over the last axis."""
    x, y = vectors[:, :, 0], vectors[:, :, 1]
    return np.asarray(np.sqrt(x * x + y * y))


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
