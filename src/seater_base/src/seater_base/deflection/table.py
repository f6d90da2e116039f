"""Everything a person sets about an analogue joystick's input (config/deflection.yaml): a measured curve per axis."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

from seater_common.params import param

_VOLTS = (1.4, 1.8, 2.2, 2.3, 2.5, 2.7, 2.8, 3.2, 3.6)


@dataclass(frozen=True)
class AxisTable:
    """One axis: what speed the chair keeps at which voltage, from the one end to the other."""

    neutral: float = param(2.5, "V", "of the stick that was let go: the chair stands", low=0.0, high=15.0)
    lowest: float = param(1.2, "V", "never less, whatever is asked for", low=0.0, high=15.0)
    highest: float = param(3.8, "V", "never more", low=0.0, high=15.0)
    volts: tuple[float, ...] = param(_VOLTS, "V", "measured at these, rising", low=0.0, high=15.0)
    speeds: tuple[float, ...] = param(
        (-0.5, -0.3, -0.08, 0.0, 0.0, 0.0, 0.08, 0.3, 0.5), "m/s, rad/s", "there; 0 in the deadband", low=-4.0, high=4.0
    )

    def __post_init__(self) -> None:
        problem = self._problem()
        if problem:
            raise ValueError(problem)

    def _problem(self) -> str:
        volts, speeds = self.volts, self.speeds
        if len(volts) != len(speeds):
            return f"{len(volts)} volts and {len(speeds)} speeds: they belong together"
        if any(b <= a for a, b in pairwise(volts)):
            return "volts do not rise"
        if not self.lowest <= min(volts, default=0.0) < max(volts, default=0.0) <= self.highest:
            return f"volts have to lie between lowest and highest, {self.lowest} and {self.highest} V"
        if min(speeds) >= 0.0 or max(speeds) <= 0.0:
            return "speeds go one way only"
        still = [v for v, speed in zip(volts, speeds, strict=True) if speed == 0.0]
        if not still or not still[0] <= self.neutral <= still[-1]:
            return f"neutral is {self.neutral} V, but the chair stands " + (
                f"from {still[0]} to {still[-1]} V" if still else "nowhere"
            )
        return self._not_monotonic()

    def _not_monotonic(self) -> str:
        sign = 1.0 if self.speeds[-1] > self.speeds[0] else -1.0
        for (v, a), (w, b) in pairwise(zip(self.volts, self.speeds, strict=True)):
            if sign * (b - a) < 0.0 or (a == b != 0.0):
                turns = "turns back" if a != b else "does not change"
                return (
                    f"not monotonic: the speed {turns} from {a} at {v} V to {b} at {w} V; measure anew, or leave it out"
                )
        return ""


@dataclass(frozen=True)
class DeflectionTable:
    """The whole of config/deflection.yaml."""

    drive: AxisTable = field(default_factory=AxisTable)
    turn: AxisTable = field(default_factory=lambda: AxisTable(speeds=(0.8, 0.4, 0.1, 0.0, 0.0, 0.0, -0.1, -0.4, -0.8)))
