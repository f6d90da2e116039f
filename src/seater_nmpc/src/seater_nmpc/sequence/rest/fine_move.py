"""The last correction, if one is needed: one small deliberate move, straight or turning on the spot.

It is timed, as it is over before odometry or images could steer it: of all pushes with one command for some cycles,
that is chosen which leaves least on average over what is known of the chair (push_response.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Limits
from seater_nmpc.drive.axis import AxisDrive, ChairDrive
from seater_nmpc.sequence.rest.push_response import PushResponse
from seater_nmpc.sequence.rest.roll import Roll

Array = NDArray[np.float64]

# [s]; of one that a roll undoes more: one that rolled 38 mm came back to where it was, thirty times. And more where it
# has rolled far: after a turn on the spot it has two such ways to go.
_LONGEST = 0.6
_FASTEST = (0.08, 0.35)  # [m/s, rad/s]
_LONGEST_LAG = 0.3  # [s] that is reckoned with: rolls, and castors that swing round, are learned as lag, too
_TINY = 1e-6  # [m/s or rad/s]: the smallest command
_PUSHED = 0.2  # [s] that a turn takes, about
_MUST = 2.0  # times what not moving leaves: a push that fails teaches, and costs less than another attempt
# The same of a push ahead, which turns no castor round: of 41 first ones of 3 to 6 mm (independent chair and campaign)
# two left more than there was before; what was left, too far weighted, was 0.5 of what was reckoned with.
_AHEAD = 1.5
# The same of the first pushes back of a chair that rolls, of which far more is reckoned with than is left: of 35 that
# do 31 stood within 5 mm instead of 28 with 1.0.
_AGAINST = 4.5
_ROLLS_ON = 0.01  # [m] from which on a roll is reckoned with so
_LEVELS = 24  # commands that are compared

Learned = dict[tuple[bool, bool], PushResponse]  # by (turning, pushed back or right)


class FineMove:
    """Ask it for the speeds of each cycle, until there are none. Errors: the chair in the dock's frame (3,)."""

    def __init__(
        self,
        error: Array,
        turning: bool,
        drive: ChairDrive,
        limits: Limits,
        period: float,
        before: FineMove | None = None,
        *,
        roll: Roll | None = None,
        leave: float = 0.0,
        must: bool = False,
        early: bool = False,
    ) -> None:
        """`error`: of the standing chair; `period` of the cycles [s]. `before`: the last move of this attempt, from
        whose result it learns. `roll`: as its stops have shown. `leave` [m or rad]: the error that is to be left, as
        what follows will mend it. `must`: it cannot stay there, and another attempt is the alternative. `early`:
        few moves were made so far."""
        self.turning, self._index = turning, 2 if turning else 0
        self._axis, self._rate = (drive.omega, limits.alpha_max) if turning else (drive.v, limits.a_max)
        self._most = limits.omega_max if turning else limits.v_bay_max  # that is sent at the dock
        lag = min(drive.lag_omega if turning else drive.lag_v, _LONGEST_LAG)
        self._begin = float(error[self._index])
        roll = roll or Roll()
        if not turning:
            self._axis = _level(self._axis, roll)
        self._drift = roll.turn(_PUSHED) if turning else 0.0  # [rad] by itself meanwhile
        self._wanted = self._begin + self._drift - leave
        # A chair that rolls ahead by more than it has to is pushed against its roll.
        rolls_past = not turning and 0.0 < -self._wanted < roll.way()
        self._ahead = self._wanted < 0.0 and not rolls_past  # or left
        self._learned: Learned = {}
        if before is not None:
            before.learn(error)
            self._learned = before._learned
        key = (turning, not self._ahead)
        if key not in self._learned:
            other = self._learned.get((turning, not key[1]))
            self._learned[key] = PushResponse(turning, self._axis, lag, other)
        self._response = self._learned[key]
        self._response.saw(roll, self._sign)
        ahead = not turning and self._ahead
        against = early and not turning and not self._ahead and roll.seen
        # Too far is no worse than too short where the roll brings it on (if a push has shown it as well), or has to be
        # mended by another push, after which the castors stand otherwise.
        rolls_on = before is not None and not self._ahead and roll.way() > _ROLLS_ON
        self._one_way = abs(roll.way()) > _ROLLS_ON if turning else rolls_on
        self._period, self._worth = period, _AGAINST if against else _MUST if must else _AHEAD if ahead else 1.0
        self._plan = self._best()  # commands of all cycles
        self._cycle, self._shown, self._left = 0, False, False

    @property
    def resistance(self) -> float:
        """[m/s or rad/s] that it reckons with, on average."""
        return self._response.resistance

    @property
    def _sign(self) -> float:
        """Of the speed that is asked for."""
        return 1.0 if self._ahead else -1.0

    @property
    def pushed(self) -> float:
        """[s] that it takes."""
        return self._period * len(self._plan)

    @property
    def is_worthwhile(self) -> bool:
        """False: the chair would be expected to stand no better after any push."""
        return len(self._plan) > 0

    def speeds(self) -> tuple[float, float] | None:
        """(v, omega) [m/s, rad/s] for the next cycle; None: it is over."""
        if self._cycle >= len(self._plan):
            return None
        command = float(self._plan[self._cycle])
        self._cycle += 1
        speed = self._sign * max(self._axis.effective(command), _TINY)
        return (0.0, speed) if self.turning else (speed, 0.0)

    def _best(self) -> Array:
        """Commands (k,) of the push that leaves least; none where not moving leaves less."""
        smallest = self._axis.command(_TINY)
        speed, longest = _FASTEST[self.turning], _LONGEST
        if not self._ahead:  # away from the dock; what it will roll back has to be driven, too
            back = max(0.0, -self._response.roll)
            far = max(0.0, self._wanted - 0.5 * speed * longest) if back else 0.0
            speed, longest = speed + back / (0.5 * _LONGEST), longest + (back + far) / (0.5 * self._most)
        fastest = max(min(self._axis.command(speed), self._most), smallest)
        most = max(1, round(longest / self._period))
        ramp = self._rate * self._period * np.arange(1, most + 1)
        levels, cycles = np.linspace(smallest, fastest, _LEVELS), np.arange(1, most + 1)
        pushes = np.minimum(ramp, levels[:, None])[None] * (ramp <= ramp[cycles - 1, None])[:, None]
        pushes = pushes.reshape(-1, most)
        losses = self._response.losses(pushes, self._period, -self._sign * self._wanted, one_way=self._one_way)
        best = pushes[np.argmin(losses)]
        return best[best > 0.0] if losses.min() < self._worth * self._wanted**2 else np.zeros(0)

    def leave(self) -> None:
        """The chair drives away before anything else is made of what it has shown; counts once."""
        if self._left:
            return
        self._shown = self._left = True
        for response in self._learned.values():
            response.forget()

    def learn(self, error: Array) -> None:
        """From where the chair stands after it; counts once."""
        left = float(error[self._index])
        if self._shown:
            return
        self._shown = True
        if self.is_worthwhile:
            moved = self._begin + self._drift - left
            self._response.learn(self._plan, self._period, -self._sign * moved)
        for key, response in self._learned.items():
            if key != (self.turning, not self._ahead):
                response.forget()


def _level(axis: AxisDrive, roll: Roll) -> AxisDrive:
    """Without the roll, that was learned with it: it takes off, or adds to, each speed ahead, as friction does."""
    return replace(axis, deadband=max(0.0, axis.deadband + roll.speed)) if axis.offset else axis
