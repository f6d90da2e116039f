"""Drives the script: one command for each period from the newest odometry, and zero whatever ends it."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_common.se2 import relative, wrap_angle
from seater_identify.drive.moves import OMEGA, Creep, Pause, Travel, TurnBack, V
from seater_identify.drive.script import make_script, origin_in_area
from seater_identify.settings import IdentifySettings

Array = NDArray[np.float64]

REACTION = 0.25  # [s] typical delay and lag of a chair, by which a stop is begun early; an error only moves the stop
ASTRAY = 0.05  # [rad] off the planned heading, from which the chair turns back before a straight
TURN_BACK = 0.25  # [rad/s], less for a small turn, which would be over before it began
TURNS_BACK = 2  # before one straight: a chair that does not obey small commands goes on as it stands
SHORTEST_STAND = 0.5  # [s] of standing that tells a gyro's bias


class DriveState(Enum):
    """Where the drive is."""

    READY = "ready"
    DRIVING = "driving"
    DONE = "done"
    STOPPED = "stopped"


class Driver:
    """One drive. `odometry` whenever it comes, `command` once for each period; `text` says what is done, or why not."""

    def __init__(self, settings: IdentifySettings, chair: Chair) -> None:
        """Raises AreaError when the area is too small."""
        self._settings, self._chair = settings, chair
        self._moves = make_script(settings, chair)
        self._ahead = origin_in_area(settings, chair)
        self.state, self.text = DriveState.READY, "waiting for the start"
        self._pose: Array | None = None  # base_link in odom
        self._start: Array = np.zeros(3)
        self._stamp, self._received = -math.inf, -math.inf
        self._travelled = [0.0, 0.0]  # [m], [rad], signed sums
        self._command = [0.0, 0.0]
        self._index, self._began, self._moved_at = 0, 0.0, math.inf
        self._origin = [0.0, 0.0]  # of `_travelled`, at the beginning of the move
        self._braking, self._turns_back = False, 0
        self._bias, self._stood = 0.0, [0.0, 0.0]  # [rad/s]; turn and time while standing
        self._planned, self._goal = [0.0, 0.0], 0.0  # where the moves so far should have led; where this one ends

    def odometry(self, stamp: float, pose: ArrayLike, now: float) -> None:
        """A pose (x [m], y [m], heading [rad]) of base_link in odom; `now`: when it arrived. Old ones: left out."""
        new = np.asarray(pose, dtype=float)
        if stamp <= self._stamp or not np.all(np.isfinite(new)):
            return
        if self._pose is not None:
            step = relative(self._pose, new)
            self._travelled[V] += float(step[0])
            turn = wrap_angle(float(step[2]))
            self._travelled[OMEGA] += turn - self._bias * (stamp - self._stamp)
            self._observe_bias(turn, stamp - self._stamp)
        self._pose, self._stamp, self._received = new, stamp, now

    def _observe_bias(self, turn: float, duration: float) -> None:
        """While the chair stands at the start, a turn is a gyro's bias."""
        if self.state is DriveState.READY or self._index == 0:
            self._stood[0] += turn
            self._stood[1] += duration
        elif self._stood[1] > SHORTEST_STAND:
            self._bias, self._stood = self._stood[0] / self._stood[1], [0.0, 0.0]

    def start(self, now: float) -> bool:
        """Begin, if there is fresh odometry; `text` says why not."""
        if self.state is not DriveState.READY:
            self.text = f"the drive is {self.state.value}"
            return False
        if self._pose is None or now - self._received > self._settings.drive.odometry_timeout:
            self.text = "no odometry arrives"
            return False
        self.state, self._start, self._travelled = DriveState.DRIVING, self._pose, [0.0, 0.0]
        self._begin(0, now)
        return True

    def stop(self, reason: str) -> None:
        """End it; commands are zero from now on."""
        if self.state is DriveState.DRIVING:
            self.state, self.text, self._command = DriveState.STOPPED, reason, [0.0, 0.0]

    def command(self, now: float) -> tuple[float, float]:
        """(v [m/s], omega [rad/s]) to send now; call it once for each period."""
        if self.state is DriveState.DRIVING:
            self._check(now)
        if self.state is not DriveState.DRIVING:
            return 0.0, 0.0
        wanted = self._wanted(now)
        limits, period = self._chair.limits, self._settings.drive.period
        for axis, rate in ((V, limits.a_max), (OMEGA, limits.alpha_max)):
            change = wanted[axis] - self._command[axis]
            self._command[axis] += max(-rate * period, min(rate * period, change))
        return self._command[V], self._command[OMEGA]

    @property
    def progress(self) -> float:
        """Share of the moves that are done."""
        return self._index / len(self._moves)

    def _take_drift(self) -> None:
        """A chair that has slid along the way while it turned (on a slope) has travelled so far, too."""
        assert self._pose is not None
        self._travelled[V] = float(relative(self._start, self._pose)[0])
        self._origin[V] = self._travelled[V]

    def _check(self, now: float) -> None:
        if now - self._received > self._settings.drive.odometry_timeout:
            self.stop(f"no odometry for {self._settings.drive.odometry_timeout} s")
        elif self._left_area():
            self.stop("the chair is leaving the free area: does it slide on a slope? A larger area lets it go on")

    def _left_area(self) -> bool:
        area = self._settings.area
        assert self._pose is not None
        corners = self._chair.corners_at(relative(self._start, self._pose))
        x, y = corners[:, 0] + self._ahead, np.abs(corners[:, 1])
        outside = max(float(np.max(x)) - area.length, -float(np.min(x)), float(np.max(y)) - 0.5 * area.width)
        return outside > area.tolerance

    def _wanted(self, now: float) -> list[float]:
        """What the move asks for; goes on to the next one when it is over."""
        move, elapsed = self._moves[self._index], now - self._began
        wanted = [0.0, 0.0]
        if isinstance(move, Pause):
            if elapsed >= move.duration - 1e-9:
                self._next(now)
            return wanted
        over = elapsed > move.longest or (
            self._travel_over(move) if isinstance(move, Travel) else self._creep_over(move, now)
        )
        self._braking = self._braking or over
        if not self._braking:
            wanted[move.axis] = self._asked(move, elapsed)
        elif self._command[move.axis] == 0.0:
            self._next(now)
        return wanted

    def _asked(self, move: Travel | Creep, elapsed: float) -> float:
        if isinstance(move, Travel):
            return math.copysign(move.speed, move.amount)
        grown = abs(move.low) * 2.0 ** (elapsed / move.double)
        return math.copysign(min(grown, abs(move.high)), move.high)

    def _travel_over(self, move: Travel) -> bool:
        rate = self._chair.limits.a_max if move.axis == V else self._chair.limits.alpha_max
        speed = abs(self._command[move.axis])
        stopping = 0.5 * speed**2 / rate + REACTION * speed
        left = (self._goal - self._travelled[move.axis]) * math.copysign(1.0, move.amount)
        return left <= stopping

    def _creep_over(self, move: Creep, now: float) -> bool:
        if abs(self._travelled[move.axis] - self._origin[move.axis]) >= move.moved:
            self._moved_at = min(self._moved_at, now)
        return now - self._moved_at >= move.after

    def _next(self, now: float) -> None:
        if self._index + 1 == len(self._moves):
            self.state, self.text, self._command = DriveState.DONE, "done", [0.0, 0.0]
            return
        following, off = self._moves[self._index + 1], self._planned[OMEGA] - self._travelled[OMEGA]
        if isinstance(following, Travel) and following.axis == V:
            if abs(off) > ASTRAY and self._turns_back < TURNS_BACK:
                turn = TurnBack(OMEGA, off, min(TURN_BACK, 2.0 * abs(off)))
                self._moves[self._index + 1 : self._index + 1] = [turn, self._moves[self._index]]
                self._turns_back += 1
            else:
                self._turns_back = 0
        self._begin(self._index + 1, now)

    def _begin(self, index: int, now: float) -> None:
        self._index, self._began, self._moved_at, self._braking = index, now, math.inf, False
        self._origin = list(self._travelled)
        move = self._moves[index]
        if isinstance(move, TurnBack):
            self._goal = self._planned[move.axis]
        elif isinstance(move, Travel):  # from where the chair should be, so that errors do not add up
            if move.axis == V:
                self._take_drift()
            self._planned[move.axis] += move.amount
            self._goal = self._planned[move.axis]
        names = ("straight", "turn")
        kind = "slow rise of the command" if isinstance(move, Creep) else "drive"
        self.text = "standing" if isinstance(move, Pause) else f"{kind}, {names[move.axis]}"
