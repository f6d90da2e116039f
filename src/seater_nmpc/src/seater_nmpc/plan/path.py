"""A way to the corridor, and how it is made of the lattice's poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import wrap_angle
from seater_nmpc.plan.lattice import BACKWARD, FORWARD

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# [rad] A larger turn comes before driving: backing out of it would take the markers out of view.
_TURNED_ON_THE_WAY = 0.4


@dataclass(frozen=True)
class Path:
    """A way to the corridor, in the dock's frame."""

    poses: Array  # (n, 3)
    backward: NDArray[np.bool_]  # (n,) whether the motion that ends in this pose is backward
    duration: float  # [s] that the search reckons with


def path_of(start: Array, poses: Array, modes: Indices, duration: float) -> Path:
    """From the `start` (3,) through the lattice's `poses` (n, 3), with the mode in which each is reached.

    The step from the start onto the lattice, with a small turn on the spot, is no leg of its own: the first leg begins
    with it. A large turn before it backs up is made where it stands, as such a step would be a to and fro.
    """
    poses, backward, turns = np.vstack([start, poses]), modes == BACKWARD, _turns(modes)
    if turns < len(modes) and backward[turns]:
        if abs(wrap_angle(float(poses[turns, 2] - start[2]))) <= _TURNED_ON_THE_WAY:
            backward[:turns] = True
        else:
            poses[1 : turns + 1, :2] = start[:2]
    return Path(poses, np.concatenate([[False], backward]), duration)


def _turns(modes: Indices) -> int:
    """How many of the motions come before it drives: the step from the start onto the lattice, and turns there."""
    drives = (modes == FORWARD) | (modes == BACKWARD)
    return int(np.argmax(drives)) if drives.any() else len(modes)
