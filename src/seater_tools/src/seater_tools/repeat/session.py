"""Dock, measure, undock, N times. ROS-free: what docks and undocks is given."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from seater_nmpc.sequence.goal.results import ResultCode

# After these the chair may try again by itself: it stands, and nothing is wrong with it. After all others a person has
# to look first.
MAY_TRY_AGAIN = (
    ResultCode.FAILED_TO_STAGE,
    ResultCode.FAILED_TO_DETECT_DOCK,
    ResultCode.FAILED_TO_CHARGE,
    ResultCode.TIMEOUT,
    ResultCode.MARKER_LOST,
    ResultCode.NOT_WITHIN_TOLERANCE,
)
MOST_FAILED = 2  # dockings in a row that fail end the session


@dataclass(frozen=True, kw_only=True)
class Docked:
    """What a goal `dock` ended with, as in Dock.action."""

    code: int
    text: str
    duration: float  # [s]
    retries: int = 0
    contact: bool = False
    x: float = 0.0  # [m] estimated final error along the dock; with sd 0: not verified
    y: float = 0.0  # [m]
    heading: float = 0.0  # [rad]
    position_sd: float = 0.0  # [m]
    heading_sd: float = 0.0  # [rad]

    @property
    def success(self) -> bool:
        """Docked, on its own way."""
        return self.code == ResultCode.SUCCESS

    @property
    def measured(self) -> bool:
        """Docked, with a final error of fresh images."""
        return self.success and self.position_sd > 0.0


@dataclass(frozen=True, kw_only=True)
class Undocked:
    """What a goal `undock` ended with."""

    code: int
    text: str

    @property
    def success(self) -> bool:
        """It stands at the predock point."""
        return self.code == ResultCode.SUCCESS


class Chair(Protocol):
    """Both wait for the end of the goal; KeyboardInterrupt ends in a standing chair."""

    def dock(self) -> Docked: ...

    def undock(self) -> Undocked: ...


class Session:
    """`run` yields each docking when it has ended; `ended` says why there are no more."""

    def __init__(self, chair: Chair, wanted: int, pause: Callable[[], None] = lambda: None) -> None:
        """`pause` between two goals."""
        self._chair, self._wanted, self._pause = chair, wanted, pause
        self.ended = ""

    def run(self) -> Iterator[Docked]:
        """A chair that stands docked at the beginning undocks first, which does not count."""
        failed = done = 0
        found_docked = False
        while done < self._wanted:
            docked = self._chair.dock()
            if docked.code == ResultCode.ALREADY_DOCKED and not found_docked:
                found_docked = True
                if not self._leave():
                    return
                continue
            done += 1
            yield docked
            failed = 0 if docked.success else failed + 1
            if self._must_end(docked, failed) or (docked.success and done < self._wanted and not self._leave()):
                return
        self.ended = "all done"

    def _must_end(self, docked: Docked, failed: int) -> bool:
        if docked.success:
            return False
        if docked.code not in MAY_TRY_AGAIN:
            self.ended = f"somebody has to look first: {docked.text}"
        elif failed >= MOST_FAILED:
            self.ended = f"{failed} dockings in a row failed: {docked.text}"
        else:
            self._pause()
        return bool(self.ended)

    def _leave(self) -> bool:
        self._pause()
        undocked = self._chair.undock()
        if not undocked.success:
            self.ended = f"it did not undock: {undocked.text}"
        else:
            self._pause()
        return undocked.success
