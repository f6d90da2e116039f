"""What the stops at one dock show, from docking to docking: how the chair rolls, and how far beside its end it comes to
rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.sequence.rest.roll import Belief, Roll, RollWatch

Array = NDArray[np.float64]

_LAGS, _DOUBT = 2.5, 0.2  # times the lag, and [s], after the delay, until the motors have to stand
_LONGEST_LAG = 0.3  # [s] that is waited for: a roll is learned as lag, too
_ARRIVES_OFF = np.array([0.004, 0.005])  # [m, rad] from which on the next docking allows for it


class Stops:
    """`restart` it for each stop, or for the small move before it."""

    def __init__(self) -> None:
        self._belief, self._watch = Belief(), RollWatch()
        self._motors_stand: float | None = None  # [s] from when on they have to
        # Beside where it was to end that a docking's first stop does, ahead and turned (2,) [m, rad]; mean.
        self._arrival: Array | None = None
        self.off: Array | None = None  # the same of the last stop; None: it had no end that was known
        self._offs: list[Array] = []  # of all those of this docking

    @property
    def roll(self) -> Roll:
        """That is reckoned with."""
        return self._belief.roll

    def begin_docking(self) -> Array:
        """Where its first stop will end, beside where it is to, as the last dockings had it (2,) [m, rad]. The floor is
        the same as the last time, the load need not be."""
        self._belief, self._offs = self._belief.aged(), []
        off = np.array([self.roll.way(), self.roll.turn()]) if self._arrival is None else self._arrival
        return np.where(np.abs(off) > _ARRIVES_OFF, off, 0.0)

    def restart(self, *, moved: bool) -> None:
        """Another stop, or small move, begins; `moved`: the stop of the small move that has been watched."""
        self._motors_stand = None
        if not moved:
            self._watch = RollWatch()

    def push(self, chair: Instant, command: float) -> None:
        """A cycle of a small move [m/s or rad/s]."""
        self._watch.push(chair.stamp, command)
        self._watch.see(chair.stamp, chair.pose)

    def stand(self, chair: Instant, since: float, history: CommandHistory) -> float:
        """A cycle in which zero is asked for, as it is `since` then [s]; returns when the motors have to stand [s]."""
        if self._motors_stand is None:
            self._motors_stand = since + history.delay + _LAGS * min(history.drive.lag_v, _LONGEST_LAG) + _DOUBT
        self._watch.stop(chair.stamp, self._motors_stand)
        self._watch.see(chair.stamp, chair.pose)
        return self._motors_stand

    def ended(self, error: Array, expected: tuple[float, float] | None, *, first: bool) -> None:
        """The chair stands at `error` (3,) from the dock, where its place ahead and heading were `expected` to be
        [m, rad], None: nowhere. `first`: it is the first stop of a docking."""
        self.off = None if expected is None else error[[0, 2]] - expected
        self._offs += [] if self.off is None else [self.off]
        if first and self.off is not None:
            self._arrival = self.off if self._arrival is None else 0.5 * (self._arrival + self.off)

    @property
    def next_off(self) -> Array | None:
        """Of another way in (2,): as the last stop was; of a chair that rolls, whose stops differ by some millimetres,
        the mean of all, to which the roll adds one. None: nothing is known."""
        if not self._offs or not self.roll.seen:
            return self.off
        off = np.mean(self._offs, axis=0)
        off[0] = (len(self._offs) * off[0] + self.roll.way()) / (len(self._offs) + 1)
        return off

    def learn_roll(self, history: CommandHistory) -> None:
        """From how it came to stand: a stop that was timed badly ends elsewhere, too."""
        drive = history.drive
        self._belief = self._belief.after(self._watch, history.delay, (drive.lag_v, drive.lag_omega))
