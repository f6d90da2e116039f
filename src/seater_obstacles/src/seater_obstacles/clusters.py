"""Points to clusters, clusters to convex outlines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from seater_common.separation import convex_outline

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


def thinned(points: Array, cell: float) -> tuple[Array, Indices]:
    """Means (m, 2) of the points (n, 2) in each square cell of side `cell` [m], and how many there were (m,)."""
    if not len(points):
        return np.empty((0, 2)), np.empty(0, dtype=np.intp)
    keys = np.floor(points / cell).astype(np.int64)
    _, which, counts = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    sums = np.zeros((len(counts), 2))
    np.add.at(sums, which.reshape(-1), points)
    return sums / counts[:, None], counts.astype(np.intp)


def clusters(points: Array, link: float) -> list[Indices]:
    """Indices of the points (n, 2) of each cluster: chains of points nearer than `link` [m] to the next one."""
    if not len(points):
        return []
    pairs = cKDTree(points).query_pairs(link, output_type="ndarray")
    ones = np.ones(len(pairs), dtype=np.int8)
    graph = coo_matrix((ones, (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, labels = connected_components(graph, directed=False)
    return [np.flatnonzero(labels == label) for label in range(count)]


def size(points: Array) -> float:
    """Diagonal of the box along the axes round the points (n, 2) [m]."""
    return float(np.hypot(*(points.max(axis=0) - points.min(axis=0))))


def pieces(points: Array, max_length: float) -> list[Array]:
    """The points (n, 2) cut across their longer axis until no piece is longer than `max_length` [m]."""
    if len(points) < 2 or size(points) <= max_length:
        return [points]
    centred = points - points.mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    middle = 0.5 * (along.min() + along.max())
    upper = along > middle
    if upper.all() or not upper.any():
        return [points]
    return pieces(points[~upper], max_length) + pieces(points[upper], max_length)


def outline(points: Array, thickness: float) -> Array:
    """Convex outline (k, 2), anticlockwise, of the points (n, 2), each taken for a square of side `thickness` [m]."""
    half = 0.5 * thickness
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return convex_outline((points[:, None, :] + corners).reshape(-1, 2))
