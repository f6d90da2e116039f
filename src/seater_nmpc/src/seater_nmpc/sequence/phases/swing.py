"""Turns on the spot to both sides of the dock, by which images show where the camera sits on the chair.

While castors swing round they push the chair. They do so least where they point ahead before a turn, so a short way
straight ahead comes before each one. Poses are (x, y, heading) of base_link in the dock's frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose, wrap_angle
from seater_common.sight import Sight
from seater_nmpc.sequence.phases.clearance import keeps_clear

Array = NDArray[np.float64]
Speeds = tuple[float, float]

_ANGLES = (0.7, 0.6, 0.5, 0.4, 0.3)  # [rad] to each side of the dock, the first one that keeps enough in view
_AHEAD = 0.15  # [m] straight on before each turn: twice the trail of a castor
_SPEED, _TURN = 0.15, 0.3  # [m/s, rad/s]
_DECELERATION, _TURN_DECELERATION = 0.2, 0.4  # [m/s^2, rad/s^2] that turns and ways end with
_ARRIVED, _TURNED = 0.02, 0.03  # [m, rad]
_RESTS = (0.01, 0.02)  # [m, rad] on which it still rolls, as good as at rest
_NEXT_TURN = 0.5  # [rad] that has to be clear ahead, whatever has come into the way since
_PARTS = np.array([[0.0, 0.0, part / 3.0] for part in (1, 2, 3)])  # of it, that are looked at
_MARGIN = 0.1  # [m] that the footprint keeps from walls and obstacles
_LONGEST = 12.0  # [s] for a turn, a third of it for a way: a chair that its motors do not turn goes on without it
_STEPS = 12


class Swing:
    """Ask it for speeds in each cycle; None: it has turned to both sides, and looks at the dock again."""

    def __init__(self, chair: Chair, dock: Dock, sight: Sight) -> None:
        self._chair, self._sight, self._walls = chair, sight, dock.bay.outlines()
        self._middle = dock.front[:2]
        self._now, self._pose, self._rest, self._areas = 0.0, np.zeros(3), np.zeros(3), self._walls
        self._steps = self._swing()

    def speeds(self, now: float, pose: Array, rest: Array, obstacles: list[Array]) -> Speeds | None:
        """(v, omega) for this cycle at the time `now` [s]. `rest`: where the chair would come to rest; `obstacles`:
        their outlines (n, 2) as of now."""
        self._now = now
        self._pose, self._rest, self._areas = pose, rest, [*self._walls, *obstacles]
        return next(self._steps, None)

    def has_room(self, pose: Array, obstacles: list[Array]) -> bool:
        """Whether there is room for its turns here; what comes into the way later ends a turn or drive."""
        self._pose, self._areas, widest = pose, [*self._walls, *obstacles], _ANGLES[0]
        aside = np.linspace(-widest, widest, _STEPS)[:, None]
        return self._clear([*pose[:2], self._towards(pose)] + aside * [0.0, 0.0, 1.0])

    def _swing(self) -> Iterator[Speeds]:
        first = math.copysign(1.0, wrap_angle(float(self._pose[2]) - self._towards(self._pose)))
        for side in (first, -first, 0.0):
            yield from self._straight()
            yield from self._turn(self._towards(self._pose) + side * self._widest(side))

    def _widest(self, side: float) -> float:
        """Angle [rad] to this side that keeps two markers in view, or else one."""
        towards = self._towards(self._pose)
        turned = np.array([[*self._pose[:2], towards + side * angle] for angle in _ANGLES])
        in_view = self._sight.seen(turned).sum(axis=1)
        return next((a for fewest in (2, 1) for a, n in zip(_ANGLES, in_view, strict=True) if n >= fewest), 0.0)

    def _straight(self) -> Iterator[Speeds]:
        start, until = self._pose[:2], self._now + _LONGEST / 3.0
        while (left := _AHEAD - math.dist(self._rest[:2], start)) > _ARRIVED and self._clear(
            compose(self._pose, [_AHEAD, 0.0, 0.0])[None]
        ):
            if self._now > until:
                return
            yield min(_SPEED, math.sqrt(2.0 * _DECELERATION * left)), 0.0
        while math.dist(self._rest[:2], self._pose[:2]) > _RESTS[0] and self._now < until:
            yield 0.0, 0.0

    def _turn(self, heading: float) -> Iterator[Speeds]:
        until = self._now + _LONGEST
        while abs(left := wrap_angle(heading - float(self._rest[2]))) > _TURNED and self._now < until:
            ahead = math.copysign(min(abs(left), _NEXT_TURN), left)
            if not self._clear(self._pose + ahead * _PARTS):
                return
            yield 0.0, math.copysign(min(_TURN, math.sqrt(2.0 * _TURN_DECELERATION * abs(left))), left)
        while abs(wrap_angle(float(self._rest[2] - self._pose[2]))) > _RESTS[1] and self._now < until:
            yield 0.0, 0.0

    def _towards(self, pose: Array) -> float:
        """Heading at which the camera looks at the middle of the markers."""
        return math.atan2(self._middle[1] - pose[1], self._middle[0] - pose[0]) - self._sight.mount.yaw

    def _clear(self, poses: Array) -> bool:
        return keeps_clear(self._chair, self._pose, poses, self._areas, _MARGIN)
