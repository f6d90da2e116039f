"""A lattice of poses ahead of the dock, and the time that each motion between two of them takes.

Sixteen headings along the grid's own directions (1, 0), (2, 1), (1, 1), (1, 2) ..., so that driving straight leads from
node to node exactly; a bend leads from one heading to the next along a parabola whose tangents are these headings,
which a unicycle can drive exactly, too. (State lattice: Pivtoraiko, Knepper, Kelly 2009.) Everything is in the dock's
frame.

A node is (mode, heading, row along x, column along y). The mode is what the chair does there: drive forward, drive
backward, or stand, having driven forward last or not; changing it costs the time to brake or to gain speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_nmpc.parameters import PlannerParameters

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_QUADRANT = ((1, 0), (2, 1), (1, 1), (1, 2))
VECTORS = np.array(
    [
        (x, y) if q == 0 else (-y, x) if q == 1 else (-x, -y) if q == 2 else (y, -x)
        for q in range(4)
        for x, y in _QUADRANT
    ]
)
HEADINGS = np.arctan2(VECTORS[:, 1], VECTORS[:, 0])  # [rad], (16,)
FORWARD, BACKWARD, STAND, STAND_AFTER_FORWARD = 0, 1, 2, 3  # modes; a path begins with STAND
MODES = 4
# [s] that driving backward costs beside its time. Nobody in the seat likes it, and on a real chair, whose motors and
# castors have to turn round each time, a few decimetres back and forth take as long.
_BACKWARD = 2.0
# [s] more where it has driven forward before: to back up first is one change of direction, and this is two.
_AFTER_FORWARD = 3.0


@dataclass(frozen=True)
class Motion:
    """A motion that starts with heading `heading` (an index) in any cell."""

    mode: int
    heading: int
    heading_after: int
    shift: tuple[int, int]  # cells
    duration: float  # [s]
    middle: tuple[
        float, float, float
    ]  # pose half-way, seen from the first cell, turned into the dock's axes [m, m, rad]


class Lattice:
    """Nodes as indices: ((mode * 16 + heading) * rows + row) * columns + column."""

    def __init__(self, chair: Chair, parameters: PlannerParameters) -> None:
        p = self._parameters = parameters
        self.cell = p.cell
        ahead, aside = math.ceil(p.reach / p.cell), math.ceil(p.half_width / p.cell)
        beyond = math.ceil(0.3 / p.cell)
        self.x = p.cell * np.arange(-ahead, beyond + 1)
        self.y = p.cell * np.arange(-aside, aside + 1)
        self.shape = (len(HEADINGS), len(self.x), len(self.y))
        self.size = math.prod(self.shape)  # poses; nodes are MODES times as many
        self._limits = chair.limits
        self.motions = [motion for heading in range(len(HEADINGS)) for motion in self._motions(heading)]

    def poses(self) -> Array:
        """(size, 3) the pose of each heading and cell."""
        heading, x, y = np.meshgrid(HEADINGS, self.x, self.y, indexing="ij")
        return np.column_stack([x.ravel(), y.ravel(), heading.ravel()])

    def pose_index(self, nodes: Indices) -> Indices:
        """Which pose a node has."""
        return nodes % self.size

    def edges(self, motion: Motion) -> tuple[Indices, Indices]:
        """Poses (indices) in which the motion begins and ends, wherever both are on the lattice."""
        (dx, dy), (_, rows, columns) = motion.shift, self.shape
        row = np.arange(max(0, -dx), min(rows, rows - dx))
        column = np.arange(max(0, -dy), min(columns, columns - dy))
        grid = row[:, None] * columns + column[None, :]
        start = motion.heading * rows * columns + grid
        end = motion.heading_after * rows * columns + grid + dx * columns + dy
        return start.ravel(), end.ravel()

    def mode_changes(self) -> list[tuple[int, int, float]]:
        """(mode, mode after, duration [s]): the time that braking or gaining speed costs beside driving through.
        Driving backward costs more."""
        limits = self._limits
        forward, backward = 0.5 * limits.v_max / limits.a_max, 0.5 * limits.v_reverse_max / limits.a_max
        return [
            (FORWARD, STAND_AFTER_FORWARD, forward),
            (STAND_AFTER_FORWARD, FORWARD, forward),
            (STAND, FORWARD, forward),
            (BACKWARD, STAND, backward),
            (STAND, BACKWARD, backward + _BACKWARD),
            (STAND_AFTER_FORWARD, BACKWARD, backward + _BACKWARD + _AFTER_FORWARD),
        ]

    def _motions(self, heading: int) -> list[Motion]:
        count, limits = len(HEADINGS), self._limits
        result = []
        for mode, sign, speed in ((FORWARD, 1, limits.v_max), (BACKWARD, -1, limits.v_reverse_max)):
            if speed <= 0.0:
                continue
            for after in (heading, heading - 1, heading + 1):
                result.append(self._drive(mode, sign, speed, heading, after % count))
        for after in (heading - 1, heading + 1):
            turn = math.remainder(float(HEADINGS[after % count] - HEADINGS[heading]), 2.0 * math.pi)
            half = (0.0, 0.0, float(HEADINGS[heading]) + 0.5 * turn)
            duration = abs(turn) / limits.omega_max
            for mode in (STAND, STAND_AFTER_FORWARD):
                result.append(Motion(mode, heading, after % count, (0, 0), duration, half))
        return result

    def _drive(self, mode: int, sign: int, speed: float, heading: int, after: int) -> Motion:
        """Straight on, or a bend: the parabola with the control points 0, a, a + b."""
        a, b = sign * VECTORS[heading], sign * VECTORS[after]
        turn = math.remainder(float(HEADINGS[after] - HEADINGS[heading]), 2.0 * math.pi)
        if after == heading:
            b = np.zeros(2, dtype=int)
        way = self.cell * float(np.hypot(*a) + np.hypot(*b))
        duration = max(way / speed, abs(turn) / (0.8 * self._limits.omega_max))
        middle = self.cell * (0.5 * a if after == heading else 0.75 * a + 0.25 * b)
        shift = a + b
        return Motion(
            mode,
            heading,
            after,
            (int(shift[0]), int(shift[1])),
            duration,
            (float(middle[0]), float(middle[1]), float(HEADINGS[heading]) + 0.5 * turn),
        )
