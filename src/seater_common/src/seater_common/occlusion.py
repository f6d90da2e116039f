"""Which lines of sight walls and other upright things block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

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

    @cached_property
    def half_spaces(self) -> tuple[Array, Array]:
        """Outward normals (n + 2, 3) and distances (n + 2,) of the faces: inside is where normal . p <= distance."""
        normals = outward_normals(self.outline[None])[0]
        upright = np.column_stack([normals, np.zeros(len(normals))])
        faces = np.vstack([upright, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
        return faces, np.append(np.sum(normals * self.outline, axis=1), [self.height, 0.0])


def side_wall_prisms(bay: Bay) -> list[Prism]:
    """The bay's side walls, in the dock's frame; none of an open dock."""
    return [Prism(wall, bay.wall_height) for wall in bay.side_walls()]


def blocked(eyes: Array, points: Array, prisms: Sequence[Prism]) -> NDArray[np.bool_]:
    """(n, m): whether a prism stands between eye and point, for n eyes and m points, (n, 3) and (m, 3) [m].

    The segment is cut by all half-spaces (Cyrus and Beck, 1978); what is left of it lies inside.
    """
    eyes, points = np.asarray(eyes, dtype=float), np.asarray(points, dtype=float)
    if not prisms:
        return np.zeros((len(eyes), len(points)), dtype=bool)
    faces, distances = (np.concatenate(parts) for parts in zip(*(prism.half_spaces for prism in prisms), strict=True))
    first = np.cumsum([0, *(len(prism.half_spaces[1]) for prism in prisms[:-1])])  # face of each prism
    at_eye = (eyes @ faces.T - distances)[:, None, :]
    change = (points @ faces.T - distances)[None, :, :] - at_eye
    along = change == 0.0
    where = -at_eye / np.where(along, 1.0, change)  # where the segment crosses the face
    begin = np.maximum.reduceat(np.where(change < 0.0, where, 0.0), first, axis=2)
    end = np.minimum.reduceat(np.where(change > 0.0, where, 1.0), first, axis=2)
    outside = np.logical_or.reduceat(along & (at_eye > 0.0), first, axis=2)  # beside a face that it runs along
    cut = np.minimum(end, 1.0) - np.maximum(begin, 0.0)
    return np.asarray(np.any(~outside & (cut > _GRAZING), axis=2))
