"""The drive of `--move`: 5 cm ahead, a turn on the spot to both sides, some more ahead, and back to where it began.

ROS-free: odometry in, commands out. Whatever ends it, the next command is zero. The first 5 cm show whether chair and
odometry go the way that is asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Limits
from seater_common.se2 import relative, wrap_angle

Array = NDArray[np.float64]

PROBE = 0.05  # [m] of the first piece
SPEED, TURNING = 0.08, 0.30  # [m/s], [rad/s]: slow, and beyond the deadband of a usual chair
REACTION = 0.25  # [s] delay and lag, by which a stop is begun early; an error only moves the stop
STAND = 1.5  # [s] at rest after each piece: castors and the camera's pole come to rest, images are averaged
# A piece that lasts longer than SLOWEST times its way at SPEED, and LATEST more, is given up. With an odometry that
# says too little, that bounds how far the chair goes: 0.49 m where 0.25 m are asked for.
SLOWEST, LATEST = 1.4, 1.5
DEAD, MOVED = 1.5, (0.005, 0.03)  # [s] after which it must have moved by so much, [m], [rad]
ASTRAY = (0.03, math.radians(5.0))  # [m], [rad] beyond the end, or the other way, at which the drive ends
SILENCE = 0.3  # [s] without odometry, which ends it


@dataclass(frozen=True)
class Piece:
    """Ahead by `way` [m], or on the spot by `turn` [rad], signed; the other is zero."""

    way: float = 0.0
    turn: float = 0.0

    @property
    def amount(self) -> float:
        return self.way + self.turn


def pieces(way: float, turn: float) -> list[Piece]:
    """There and back; without a turn where `turn` is 0. The turn comes before the rest of the way, far from walls."""
    probe = min(PROBE, way)
    turns = [Piece(turn=turn), Piece(turn=-2.0 * turn), Piece(turn=turn)] if turn > 0.0 else []
    rest = [Piece(way=way - probe)] if way > probe else []
    return [Piece(way=probe), *turns, *rest, Piece(way=-way)]


class Stepper:
    """`odometry` whenever it comes, `command` once per period. `stopped`: why it ended early; `over`: it has ended."""

    def __init__(self, plan: list[Piece], limits: Limits, period: float) -> None:
        self._plan, self._limits, self._period = plan, limits, period
        self.stands: list[tuple[float, float]] = []  # stamps [s] between which the chair stood: before, after each
        self.over, self.stopped = False, ""
        self._pose: Array | None = None
        self._stamp = self._received = -math.inf
        self._index, self._v, self._omega = -1, 0.0, 0.0
        self._begun, self._origin, self._braking = -math.inf, np.zeros(3), True

    def odometry(self, stamp: float, pose: ArrayLike, now: float) -> None:
        """Pose (3,) of base_link in odom; `now` [s] on the clock of `command`. Old ones and NaN are left out."""
        new = np.asarray(pose, dtype=float)
        if stamp > self._stamp and np.all(np.isfinite(new)):
            self._pose, self._stamp, self._received = new, stamp, now

    def stop(self, why: str) -> None:
        """End it."""
        if not self.over:
            self.over, self.stopped, self._v, self._omega = True, why, 0.0, 0.0

    def command(self, now: float) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) to send now."""
        if self.over:
            return 0.0, 0.0
        if self._pose is None or now - self._received > SILENCE:
            self.stop(f"no odometry for {SILENCE} s")
            return 0.0, 0.0
        if self._begun == -math.inf:
            self._begin_stand(now)
        wanted = self._wanted(now)
        if self.over:
            return 0.0, 0.0
        self._v = _towards(self._v, wanted[0], self._limits.a_max * self._period)
        self._omega = _towards(self._omega, wanted[1], self._limits.alpha_max * self._period)
        return self._v, self._omega

    def _wanted(self, now: float) -> tuple[float, float]:
        if self._braking:
            if self._v == 0.0 and self._omega == 0.0 and now - self._begun >= STAND:
                self._next(now)
            elif self._v != 0.0 or self._omega != 0.0:
                self._begin_stand(now)
            return 0.0, 0.0
        piece = self._plan[self._index]
        gone = self._gone(piece) * math.copysign(1.0, piece.amount)
        self._check(piece, gone, now - self._begun)
        if gone >= abs(piece.amount) - self._stopping(piece):
            self._begin_stand(now)
        if self.over or self._braking:
            return 0.0, 0.0
        speed = math.copysign(SPEED if piece.way else TURNING, piece.amount)
        return (speed, 0.0) if piece.way else (0.0, speed)

    def _check(self, piece: Piece, gone: float, elapsed: float) -> None:
        """Stop what does not do as asked."""
        kind, speed = (0, SPEED) if piece.way else (1, TURNING)
        if gone < -ASTRAY[kind]:
            self.stop("by its odometry the chair goes the other way")
        elif gone > abs(piece.amount) + ASTRAY[kind]:
            self.stop("by its odometry the chair goes farther than asked for")
        elif elapsed > DEAD and gone < MOVED[kind]:
            self.stop("by its odometry the chair does not move")
        elif elapsed > SLOWEST * abs(piece.amount) / speed + LATEST:
            self.stop("by its odometry the chair does not get there in time")

    def _gone(self, piece: Piece) -> float:
        assert self._pose is not None
        step = relative(self._origin, self._pose)
        return float(step[0]) if piece.way else wrap_angle(float(step[2]))

    def _stopping(self, piece: Piece) -> float:
        speed, rate = (self._v, self._limits.a_max) if piece.way else (self._omega, self._limits.alpha_max)
        return 0.5 * speed**2 / rate + REACTION * abs(speed)

    def _begin_stand(self, now: float) -> None:
        self._braking, self._begun = True, now

    def _next(self, now: float) -> None:
        assert self._pose is not None
        self.stands.append((self._stamp - 0.6 * STAND, self._stamp))  # the first part is the coming to rest
        self._index += 1
        self._braking, self._begun, self._origin = False, now, self._pose
        self.over = self._index == len(self._plan)


def _towards(value: float, wanted: float, most: float) -> float:
    return value + max(-most, min(most, wanted - value))
