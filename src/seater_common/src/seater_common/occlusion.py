"""Which lines of sight walls and other upright things block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Bay
from seater_common.separation import outward_normals

Array = NDArray[np.float64]

# A line of sight that touches a face (a marker hangs on it) or grazes an edge for less than this part of its length is
# not blocked.
_GRAZING = 1e-6


@dataclass(frozen=True, eq=False)
class Prism:
    """What stands on the floor: a convex anticlockwise outline (n, 2) and its height, all in one frame [m]."""

    outline: Array
    height: float


def side_wall_prisms(bay: Bay) -> list[Prism]:
    """The bay's side walls, in the dock's frame; none of an open dock."""
    return [Prism(wall, bay.wall_height) for wall in bay.side_walls()]


def blocked(eyes: Array, points: Array, prisms: list[Prism]) -> NDArray[np.bool_]:
    """(n, m): whether a prism stands between eye and point, for n eyes and m points, (n, 3) and (m, 3) [m].

    The segment is cut by one half-space after the other (Cyrus and Beck, 1978); what is left of it lies inside.
    """
    eyes, points = np.asarray(eyes, dtype=float), np.asarray(points, dtype=float)
    result = np.zeros((len(eyes), len(points)), dtype=bool)
    for prism in prisms:
        normals = outward_normals(prism.outline[None])[0]
        faces = np.vstack([np.column_stack([normals, np.zeros(len(normals))]), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        offsets = np.append(np.sum(normals * prism.outline, axis=1), [prism.height, 0.0])
        begin, end = np.zeros_like(result, dtype=float), np.ones_like(result, dtype=float)
        for face, offset in zip(faces, offsets, strict=True):
            at_eye, at_point = (eyes @ face - offset)[:, None], (points @ face - offset)[None, :]
            change = at_point - at_eye
            where = -at_eye / np.where(change == 0.0, 1.0, change)  # where the segment crosses the face
            begin = np.where(change < 0.0, np.maximum(begin, where), begin)
            end = np.where(change > 0.0, np.minimum(end, where), end)
            end = np.where((change == 0.0) & (at_eye > 0.0), -1.0, end)
        result |= end - begin > _GRAZING
    return result
