"""Looking for a dock that is not in view, by a rough pose of it: turn towards it, drive to where it can be seen, turn.

Slowly and without a plan that trusts the rough pose to a centimetre: turns on the spot, straight drives, and looking
while standing. Poses are (x, y, heading) of base_link in the frame of the dock as roughly given.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angle
from seater_nmpc.sequence.phases.clearance import keeps_clear
from seater_nmpc.sequence.phases.room import Aim, clear_turn, driven, make_room, turned

Array = NDArray[np.float64]
Speeds = tuple[float, float]

_LOOK = 2.0  # [s] standing, so that a few images can agree; at slow cameras longer: until so many images came
_IMAGES = 8
_SPEED, _TURN = 0.2, 0.35  # [m/s, rad/s]
_DECELERATION, _TURN_DECELERATION = 0.2, 0.4  # [m/s^2, rad/s^2] that turns and drives end with
_ARRIVED, _TURNED, _ABOUT = 0.1, 0.05, 0.15  # [m, rad, rad]; about: a turn that ended early has come near enough
_STEERING = 1.0  # [1/s] turning rate per angle to the place that is driven to
SWEEPS = (0.0, 0.6, -0.6, 1.2, -1.2)  # [rad] beside the direction of the dock, where the chair looks
_MARGIN = 0.1  # [m] that the footprint keeps from walls and obstacles
# [m] more from walls of a dock that has not been seen yet: of 24 chairs beside the bay, told the dock 0.25 m and 10 deg
# beside where it is, one turned a corner against the wall.
_ROUGH = 0.25
_VIEWPOINT = 1.3  # [m] from the mouth of the bay to the front of the chair, where markers are surely to be seen
_NEXT, _NEXT_TURN = 0.4, 0.5  # [m, rad] that have to be clear ahead, whatever has come into the way since
_SWEEP_STEPS = 24
_ROOMS = 3  # times that room is made for one turn: castors push the chair as it turns, by some centimetres


class Search:
    """Ask it for speeds in each cycle while the dock has not been found; None: it has looked everywhere."""

    def __init__(
        self, chair: Chair, dock: Dock, image_period: float, *, first: Sequence[float] = SWEEPS, go: bool = True
    ) -> None:
        """`image_period` [s]: usual time between two images. `first`: where it looks before it drives, beside the
        direction of the dock [rad]. `go`: drive to where the dock can be seen and look all round from there."""
        self._chair, self._dock = chair, dock
        self._areas = self._walls = dock.bay.outlines()
        self._look_time = max(_LOOK, _IMAGES * image_period)
        self._now, self._pose, self._rest = 0.0, np.zeros(3), np.zeros(3)
        self._wall_margin = _MARGIN
        self._first, self._go = first, go
        self._steps = self._search()

    def speeds(
        self, now: float, pose: Array, rest: Array, obstacles: list[Array], *, rough: bool = False
    ) -> Speeds | None:
        """(v, omega) for this cycle at the time `now` [s]. `rest`: where the chair would come to rest; `obstacles`:
        their outlines (n, 2) as of now. `rough`: the dock has not been seen, and may be elsewhere."""
        self._wall_margin = _MARGIN + _ROUGH if rough else _MARGIN
        self._now, self._pose, self._rest = now, pose, rest
        self._areas = [*self._walls, *obstacles]
        return next(self._steps, None)

    def _search(self) -> Iterator[Speeds]:
        yield from self._look_around(self._first)
        if not self._go:
            return
        bay = self._dock.bay
        viewpoint = np.array([bay.entrance_x - self._chair.length_front - _VIEWPOINT, 0.0])
        if math.dist(self._pose[:2], viewpoint) > 2.0 * _ARRIVED and self._way_clear(viewpoint):
            yield from self._turn_with_room(lambda place: _bearing(place, viewpoint))
            yield from self._drive(viewpoint)
            yield from self._look_around(SWEEPS)
        elif self._first != SWEEPS:
            yield from self._look_around(SWEEPS)

    def _look_around(self, sweeps: Sequence[float]) -> Iterator[Speeds]:
        for aside in sweeps:
            if aside == 0.0:  # before the others, from where room was made for it
                yield from self._turn_with_room(self._towards)
            else:
                yield from self._turn(self._towards(self._pose[:2]) + aside)
            since = self._now
            while self._now - since < self._look_time:
                yield 0.0, 0.0

    def _towards(self, place: Array) -> float:
        return _bearing(place, self._dock.front[:2]) - self._chair.camera.yaw

    def _turn_with_room(self, aim: Aim) -> Iterator[Speeds]:
        """As `_turn`, and where that is not clear, from a place nearby where it is."""
        for _ in range(_ROOMS):
            yield from self._turn(aim(self._pose[:2]))
            if abs(wrap_angle(aim(self._rest[:2]) - float(self._rest[2]))) <= _ABOUT:
                return
            move = make_room(self._pose, aim, self._clear)
            if move is None:
                return
            yield from self._turn(float(self._pose[2]) + move[0])
            yield from self._back_or_on(move[1])

    def _turn(self, heading: float) -> Iterator[Speeds]:
        """On the spot, whichever way round is clear, the shorter one first; not at all when none is."""
        clear = clear_turn(self._pose, heading, self._clear)
        if clear is None:
            return
        left, before = clear, float(self._rest[2])
        left -= wrap_angle(before - float(self._pose[2]))
        while abs(left) > _TURNED and self._clear(turned(self._pose, math.copysign(min(abs(left), _NEXT_TURN), left))):
            yield 0.0, math.copysign(min(_TURN, math.sqrt(2.0 * _TURN_DECELERATION * abs(left))), left)
            left -= wrap_angle(float(self._rest[2]) - before)
            before = float(self._rest[2])

    def _back_or_on(self, way: float) -> Iterator[Speeds]:
        """Straight, by `way` [m] along the chair."""
        begin, heading = self._pose[:2].copy(), float(self._pose[2])
        ahead = np.array([math.cos(heading), math.sin(heading)])
        while True:
            left = way - float((self._rest[:2] - begin) @ ahead)
            if left * way <= 0.0 or not self._clear(driven(self._pose, math.copysign(min(abs(left), _NEXT), way))):
                return
            v = math.copysign(min(_SPEED, math.sqrt(2.0 * _DECELERATION * abs(left))), way)
            off = wrap_angle(heading - float(self._pose[2]))
            yield v, min(max(_STEERING * off, -_TURN), _TURN)

    def _drive(self, place: Array) -> Iterator[Speeds]:
        """Straight to a place (x, y)."""
        while True:
            away = math.dist(self._rest[:2], place)
            off = wrap_angle(_bearing(self._pose, place) - float(self._pose[2]))
            ahead = driven(self._pose, min(away, _NEXT))[-1:]
            if away <= _ARRIVED or abs(off) > 0.5 * math.pi or not self._clear(ahead):
                return
            v = min(_SPEED, math.sqrt(2.0 * _DECELERATION * away)) * max(0.0, math.cos(off))
            yield v, min(max(_STEERING * off, -_TURN), _TURN)

    def _way_clear(self, place: Array) -> bool:
        poses = np.full((_SWEEP_STEPS, 3), _bearing(self._pose, place))
        poses[:, :2] = self._pose[:2] + np.linspace(0.1, 1.0, _SWEEP_STEPS)[:, None] * (place - self._pose[:2])
        return self._clear(poses)

    def _clear(self, poses: Array) -> bool:
        margins = [self._wall_margin if k < len(self._walls) else _MARGIN for k in range(len(self._areas))]
        return keeps_clear(self._chair, self._pose, poses, self._areas, margins)


def _bearing(here: Array, place: Array) -> float:
    return math.atan2(float(place[1] - here[1]), float(place[0] - here[0]))
