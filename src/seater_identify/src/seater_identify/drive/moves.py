"""The moves that a drive consists of. Each asks for one speed and says when it is over; standing ends all of them."""

from __future__ import annotations

from dataclasses import dataclass

V, OMEGA = 0, 1  # the axes: speed [m/s], turning rate [rad/s]


@dataclass(frozen=True)
class Pause:
    """Stand for `duration` [s]."""

    duration: float


@dataclass(frozen=True)
class Travel:
    """Drive `amount` [m] or turn it [rad] (signed) at `speed` (positive), measured by odometry."""

    axis: int
    amount: float
    speed: float

    @property
    def longest(self) -> float:
        """[s] after which it is given up: a chair that does not obey must not wait for ever."""
        return 2.5 * abs(self.amount) / self.speed + 3.0


@dataclass(frozen=True)
class TurnBack(Travel):
    """A turn to the planned heading; `amount` is about what is left."""


@dataclass(frozen=True)
class Creep:
    """Let the command grow from `low` to `high` (same sign), doubling every `double` [s], until the chair has moved.

    A geometric rise meets a deadband of any size with the same relative resolution: a step of the command is
    2^(period/double) - 1 of it, 3 % with the defaults.
    """

    axis: int
    low: float
    high: float
    double: float
    moved: float  # [m] or [rad] by which the chair must have moved ...
    after: float  # [s] ... before so long it goes on

    @property
    def longest(self) -> float:
        """[s]: the rise and as long at its end, where a chair that stands shows that it does not obey."""
        return 8.0 * self.double


Move = Pause | Travel | Creep
