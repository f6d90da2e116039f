"""What no image can show, and what is held instead: where the dock frame lies among the markers.

The camera sees markers and chair from each other only. Shift or turn the dock frame on the floor, or lift markers and
camera together: every image stays as it is. So the mean place of the markers stays as in the file, and so does their
mean turn about it. Where the docked chair stands among the markers is taught (`seater teach`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEVER = 0.05  # [m] at which a marker's own turn counts as much as its shift
_STEPS = 8  # Newton's; the second one is exact to a micrometre for turns of some degrees


def moved_as_one(places: Array, moved: Array) -> Array:
    """(4,) mean shift x, y, z [m] and turn [rad] of the markers, linear in `moved`.

    places: (n, 3) of the file; moved: (n, 4) x, y, z [m] and yaw [rad] less the file's.
    """
    arm = places[:, :2] - places[:, :2].mean(axis=0)
    turn = np.sum(arm[:, 0] * moved[:, 1] - arm[:, 1] * moved[:, 0]) + LEVER**2 * np.sum(moved[:, 3])
    return np.array([*moved[:, :3].mean(axis=0), turn / (np.sum(arm**2) + len(places) * LEVER**2)])


def held_still(file: Array, rows: Array) -> tuple[Array, Array]:
    """`rows` (n, 4), x, y, z, yaw, moved as one so that `moved_as_one` of them against `file` (n, 4) is zero; and the
    motion (4,): turned by its last about z, then shifted."""
    motion = np.zeros(4)
    for _ in range(_STEPS):
        motion -= moved_as_one(file[:, :3], _moved(rows, motion) - file)
    return _moved(rows, motion), motion


def _moved(rows: Array, motion: Array) -> Array:
    """About the origin of the dock frame."""
    c, s = np.cos(motion[3]), np.sin(motion[3])
    x, y = c * rows[:, 0] - s * rows[:, 1], s * rows[:, 0] + c * rows[:, 1]
    return np.column_stack([x + motion[0], y + motion[1], rows[:, 2] + motion[2], rows[:, 3] + motion[3]])
