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
    result = np.zeros((len(eyes), len(points)), dtype=bool)
    for prism in prisms:
        faces, distances = prism.half_spaces
        at_eye = (eyes @ faces.T - distances)[:, None, :]
        change = (points @ faces.T - distances)[None, :, :] - at_eye
        where = -at_eye / np.where(change == 0.0, 1.0, change)  # where the segment crosses the face
        begin = np.max(where, axis=2, where=change < 0.0, initial=0.0)
        end = np.min(where, axis=2, where=change > 0.0, initial=1.0)
        outside = np.any((change == 0.0) & (at_eye > 0.0), axis=2)  # beside a face that it runs along
        result |= ~outside & (end - begin > _GRAZING)
    return result
