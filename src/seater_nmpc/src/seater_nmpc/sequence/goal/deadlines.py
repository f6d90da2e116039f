"""How long a goal, each of its phases and a pause may take, in message time [s]."""

from __future__ import annotations

from dataclasses import dataclass

from seater_nmpc.parameters import Timeouts
from seater_nmpc.sequence.goal.results import Phase, ResultCode


@dataclass(frozen=True)
class Pause:
    """A person has stopped the chair at the time `since`, and may have it go on within `longest`; else the goal ends
    with `code` and `text`."""

    since: float
    longest: float
    code: ResultCode
    text: str

    def left(self, now: float) -> float:
        """Time that is left to go on; negative: none."""
        return self.longest - (now - self.since)


class Deadlines:
    """Of one goal."""

    def __init__(self, timeouts: Timeouts, start: float, timeout: float) -> None:
        """`timeout`: of the whole goal."""
        self._start, self._timeout, self._entered = start, timeout, start
        self._limits = {
            Phase.WAITING_FOR_DOCK: (timeouts.detect, ResultCode.FAILED_TO_DETECT_DOCK),
            Phase.SEARCHING: (timeouts.search, ResultCode.FAILED_TO_DETECT_DOCK),
            Phase.APPROACH: (timeouts.approach, ResultCode.FAILED_TO_STAGE),
            Phase.FINAL: (timeouts.final, ResultCode.TIMEOUT),
            Phase.STOPPING: (timeouts.stopping, ResultCode.TIMEOUT),
            Phase.CORRECTING: (timeouts.correcting, ResultCode.TIMEOUT),
            Phase.RETRY: (timeouts.retry, ResultCode.FAILED_TO_STAGE),
            Phase.STAGING: (timeouts.approach, ResultCode.FAILED_TO_STAGE),
        }

    def enter(self, now: float) -> None:
        """A phase begins."""
        self._entered = now

    def put_off(self, duration: float) -> None:
        """A pause of so long does not count."""
        self._start += duration

    @property
    def entered(self) -> float:
        """When the phase began."""
        return self._entered

    def elapsed(self, now: float) -> float:
        """Since the goal began."""
        return now - self._start

    @property
    def half(self) -> float:
        """When half of the goal's time is over."""
        return self._start + 0.5 * self._timeout

    def missed(self, now: float, phase: Phase) -> tuple[ResultCode, str] | None:
        """What the goal ends with because it took too long; None: there is time left."""
        if now - self._start > self._timeout:
            return ResultCode.TIMEOUT, f"not finished within {self._timeout:.1f} s"
        limit, code = self._limits.get(phase, (float("inf"), ResultCode.TIMEOUT))
        if now - self._entered > limit:
            if phase is Phase.STOPPING:
                return code, f"the chair has not come to rest within {limit:.1f} s"
            return code, f"{phase.name} took longer than {limit:.1f} s"
        return None
