"""A simulated base behind a pseudo-terminal: what the program of a microcontroller has to do, for tests and trials."""

from __future__ import annotations

import math
import os
import pty
import select
import threading
import time
import tty

from seater_base.protocol import ASK, VERSION, Command, Flags, Identity, Lines, Reading, encode
from seater_base.settings import WheelSettings

SILENCE = 0.3  # [s] without a command: brake, then no power
BRAKE, FASTER = 1.5, 0.8  # [m/s^2] of a wheel, slowing down and speeding up
PERIOD = 0.02  # [s] between two readings
_WORD = 2**32


class Firmware:
    """Times [s] by its own clock, which begins with it."""

    def __init__(self, wheels: WheelSettings, *, name: str = "simulated", version: int = VERSION) -> None:
        self._wheels, self._identity = wheels, Identity(version, name)
        self._lines = Lines()
        self._wanted = [0.0, 0.0]  # [m/s] of the left and right wheel
        self.speeds = [0.0, 0.0]
        self._ways = [0.0, 0.0]  # [m]
        self._heard, self._sequence = -math.inf, -1
        self.power = False
        self.emergency_stop = False  # the button
        self._let_go = False  # zero was commanded since it was pressed, and since the start
        self._said, self._now = -math.inf, 0.0
        self._out = [encode(self._identity.text())]

    def receive(self, data: bytes) -> None:
        """Bytes from the computer."""
        for message in self._lines.feed(data):
            if message == ASK:
                self._out.append(encode(self._identity.text()))
            elif isinstance(message, Command) and message.sequence != self._sequence:
                self._obey(message)

    def _obey(self, command: Command) -> None:
        """What comes with the power, or without it, moves nothing yet."""
        self._heard, self._sequence = self._now, command.sequence
        had_power, self.power = self.power, command.power
        self._let_go = self._let_go or (not self.emergency_stop and command.v == command.omega == 0.0)
        half = 0.5 * self._wheels.separation * command.omega
        drives = had_power and self.power and self._let_go
        self._wanted = [command.v - half, command.v + half] if drives else [0.0, 0.0]

    def step(self, now: float) -> bytes:
        """Drive until `now`; returns what is to be sent."""
        elapsed, self._now = now - self._now, now
        silent = now - self._heard > SILENCE
        if self.emergency_stop:
            self.power = self._let_go = False
        if silent:
            self._wanted = [0.0, 0.0]
            self.power = self.power and any(self.speeds)
        for i in (0, 1):
            self.speeds[i] = self._toward(self.speeds[i], self._wanted[i], elapsed)
            self._ways[i] += self.speeds[i] * elapsed
        if now - self._said >= PERIOD:
            self._said = max(self._said + PERIOD, now - PERIOD)  # no drift of the rate
            self._out.append(encode(self._reading(silent).text()))
        out, self._out = b"".join(self._out), []
        return out

    def _toward(self, speed: float, wanted: float, elapsed: float) -> float:
        """Without power the brakes hold: it slows down as well."""
        wanted = wanted if self.power else 0.0
        slower = abs(wanted) < abs(speed) or wanted * speed < 0.0
        most = (BRAKE if slower else FASTER) * elapsed
        return speed + min(max(wanted - speed, -most), most)

    def _reading(self, silent: bool) -> Reading:
        counts = (self._ways[0] * self._wheels.left_counts, self._ways[1] * self._wheels.right_counts)
        left, right = ((round(count) + _WORD // 2) % _WORD - _WORD // 2 for count in counts)
        states = {Flags.POWER: self.power, Flags.SILENT: silent, Flags.EMERGENCY_STOP: self.emergency_stop}
        flags = Flags(sum(flag for flag, on in states.items() if on))
        return Reading(int(1e3 * self._now) % _WORD, left, right, flags)


class SimulatedBase:
    """The firmware in a thread, behind a pseudo-terminal: `path` is its port."""

    def __init__(self, firmware: Firmware) -> None:
        self.firmware = firmware
        self._ours, theirs = pty.openpty()
        tty.setraw(theirs)
        self.path = os.ttyname(theirs)
        self._theirs = theirs  # stays open, so that a driver may come and go
        self._stop, self._begin = threading.Event(), time.monotonic()
        self.deaf = False  # the cable to the base is broken
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.is_set():
            if select.select([self._ours], [], [], 0.005)[0]:
                data = os.read(self._ours, 4096)
                if not self.deaf:
                    self.firmware.receive(data)
            out = self.firmware.step(time.monotonic() - self._begin)
            if out and select.select([], [self._ours], [], 0.0)[1]:
                os.write(self._ours, out)

    def close(self) -> None:
        """Unplugged."""
        self._stop.set()
        self._thread.join(2.0)
        os.close(self._theirs)
        os.close(self._ours)
