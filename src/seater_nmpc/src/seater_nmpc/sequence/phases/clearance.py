"""Whether the chair may stand at some poses, among walls and obstacles that it has to keep away from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, polygon_distance, polygon_distances

Array = NDArray[np.float64]

_NO_NEARER = 1e-3  # [m] of noise, where it stands too near already


def keeps_clear(chair: Chair, here: Array, poses: ArrayLike, areas: Sequence[Array], margins: ArrayLike) -> bool:
    """Whether the footprint keeps `margins` (areas,) or one [m] from convex outlines (n, 2) at all `poses` (k, 3).

    Where it stands nearer already, at `here` (3,), poses that do not bring it nearer are allowed.
    """
    footprints = _footprints(chair, np.asarray(poses, dtype=float))
    now = chair.corners_at(here)
    for area, margin in zip(areas, np.broadcast_to(margins, len(areas)), strict=True):
        least = min(float(margin), polygon_distance(now, area) - _NO_NEARER)
        if float(polygon_distances(area, footprints).min()) < least:
            return False
    return True


def _footprints(chair: Chair, poses: Array) -> Array:
    """Corners (k, 4, 2) at poses (k, 3)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turns = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=1)  # transposed
    return np.asarray(chair.corners() @ turns + poses[:, None, :2])
