"""Whether the chair may stand at some poses, among walls and obstacles that it has to keep away from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, polygon_distance, polygon_distances
from seater_common.separation import footprints

Array = NDArray[np.float64]

_NO_NEARER = 1e-3  # [m] of noise, where it stands too near already


def keeps_clear(chair: Chair, here: Array, poses: ArrayLike, areas: Sequence[Array], margins: ArrayLike) -> bool:
    """Whether the footprint keeps `margins` (areas,) or one [m] from convex outlines (n, 2) at all `poses` (k, 3).

    Where it stands nearer already, at `here` (3,), poses that do not bring it nearer are allowed.
    """
    shapes, now = footprints(chair.corners(), poses), chair.corners_at(here)
    for area, margin in zip(areas, np.broadcast_to(margins, len(areas)), strict=True):
        least = min(float(margin), polygon_distance(now, area) - _NO_NEARER)
        if float(polygon_distances(area, shapes).min()) < least:
            return False
    return True
