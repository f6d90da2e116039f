"""A scripted series of steps: one voltage after the other, with the speed that the encoders measure at each."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from statistics import fmean

from seater_base.deflection.fit import AXES, Pair
from seater_base.odometry import WheelOdometry
from seater_base.port import Port, PortError
from seater_base.protocol import ASK, Deflection, Flags, Identity, Lines, Reading, encode
from seater_base.settings import BaseSettings

_PERIOD = 0.02  # [s] between two lines
_SILENT = 0.3  # [s] without a reading: it ends
_BEGIN = 5.0  # [s] for the base to say who it is
_TWICE = 0.3  # [s] in which it may say so again: when it has just been started, it was not asked
_MEASURED = 0.5  # of a step's duration, at its end


class SeriesError(Exception):
    """The series ended early, at neutral; in words."""


@dataclass(frozen=True)
class Plan:
    """What is tried. Voltages go outward, one side and the other in turn, so that the chair stays about where it is."""

    neutral: tuple[float, float] = (2.5, 2.5)  # [V] of drive and turn
    reach: float = 1.2  # [V] outward, at most
    levels: int = 10  # to each side
    hold: float = 1.5  # [s] of each step; its second half is measured
    rest: float = 1.0  # [s] at neutral before it
    fastest: tuple[float, float] = (0.6, 0.8)  # [m/s], [rad/s] beyond which no side goes on outward

    def offsets(self) -> Iterator[float]:
        """[V] from neutral, the small ones first."""
        for k in range(1, self.levels + 1):
            yield self.reach * k / self.levels
            yield -self.reach * k / self.levels


class Series:
    """Drives a base of protocol 2 by voltages. Whatever happens, it ends with neutral and without power."""

    def __init__(
        self,
        settings: BaseSettings,
        plan: Plan,
        say: Callable[[str], None] = lambda text: None,
        *,
        open_port: Callable[[str, int], Port] = Port,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """`say` is told each pair as it is measured; port and `clock` [s] are others in tests."""
        self._settings, self._plan, self._say = settings, plan, say
        self._open, self._clock = open_port, clock
        self._lines, self._odometry = Lines(), WheelOdometry(settings)
        self._sequence, self._heard, self._begun = 0, 0.0, False
        self._identity: Identity | None = None
        self._speeds: list[tuple[float, float]] = []  # [m/s], [rad/s] since they were taken last

    def run(self) -> list[Pair]:
        """Some minutes. Raises SeriesError, PortError."""
        port = self._open(self._settings.port, self._settings.baud)
        try:
            self._greet(port)
            return [pair for axis in AXES for pair in self._axis(port, axis)]
        finally:
            with suppress(PortError):
                for _ in range(3):
                    self._send(port, self._plan.neutral, power=False)
            port.close()

    def _greet(self, port: Port) -> None:
        port.write(encode(ASK))
        end = self._clock() + _BEGIN
        while self._identity is None and self._clock() < end:
            self._listen(port, 0.1)
        if self._identity is None:
            raise SeriesError("the base does not say who it is")
        self._listen(port, _TWICE)
        if self._identity.version < 2:
            raise SeriesError(f"the base speaks protocol {self._identity.version}: voltages need protocol 2")
        self._heard, self._begun = self._clock(), True

    def _axis(self, port: Port, axis: str) -> Iterator[Pair]:
        index = AXES.index(axis)
        neutral, open_sides = self._plan.neutral[index], {1.0, -1.0}
        yield axis, neutral, self._step(port, index, neutral)
        for offset in self._plan.offsets():
            side = 1.0 if offset > 0.0 else -1.0
            if side not in open_sides:
                continue
            self._step(port, index, neutral, self._plan.rest)
            speed = self._step(port, index, neutral + offset)
            self._say(f"{axis} {neutral + offset:.2f} V: {speed:+.3f}")
            yield axis, round(neutral + offset, 3), speed
            if abs(speed) >= self._plan.fastest[index]:
                open_sides.remove(side)

    def _step(self, port: Port, index: int, volts: float, duration: float | None = None) -> float:
        """The mean speed of its second half [m/s, rad/s]."""
        duration = self._plan.hold if duration is None else duration
        both = list(self._plan.neutral)
        both[index] = volts
        begin = self._clock()
        measured: list[float] = []
        while (elapsed := self._clock() - begin) < duration:
            self._send(port, (both[0], both[1]), power=True)
            self._listen(port, _PERIOD)
            if elapsed >= _MEASURED * duration:
                measured += [speeds[index] for speeds in self._speeds]
            self._speeds.clear()
            if self._clock() - self._heard > _SILENT:
                raise SeriesError("the base is silent")
        if not measured:
            raise SeriesError("no odometry in a whole step")
        return fmean(measured)

    def _send(self, port: Port, volts: tuple[float, float], *, power: bool) -> None:
        self._sequence = (self._sequence + 1) % 2**32
        port.write(encode(Deflection(self._sequence, *volts, power).text()))

    def _listen(self, port: Port, seconds: float) -> None:
        """For so long, whatever comes."""
        end = self._clock() + seconds
        while (left := end - self._clock()) > 0.0:
            for message in self._lines.feed(port.read(left)):
                if isinstance(message, Identity):
                    if self._begun:
                        raise SeriesError("the base has started anew")
                    self._identity = message
                elif isinstance(message, Reading):
                    self._take(message)

    def _take(self, reading: Reading) -> None:
        self._heard = self._clock()
        if reading.flags & (Flags.EMERGENCY_STOP | Flags.FAULT):
            raise SeriesError("the emergency stop is pressed, or the base reports a fault")
        driven = self._odometry.add(reading, self._heard)
        if driven is not None:
            self._speeds.append((driven.v, driven.omega))
