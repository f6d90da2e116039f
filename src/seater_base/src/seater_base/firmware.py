"""A simulated base behind a pseudo-terminal: what the program of a microcontroller has to do, for tests and trials."""

from __future__ import annotations

import math
import os
import pty
import select
import threading
import time
import tty

import numpy as np

from seater_base.deflection.table import AxisTable, DeflectionTable
from seater_base.protocol import ASK, VERSION, Command, Deflection, Flags, Identity, Lines, Message, Reading, encode
from seater_base.settings import WheelSettings

SILENCE = 0.3  # [s] without a command: brake, then no power
BRAKE, FASTER = 1.5, 0.8  # [m/s^2] of a wheel, slowing down and speeding up
PERIOD = 0.02  # [s] between two readings
_WORD = 2**32
_NEUTRAL = 0.005  # [V] that count as neutral: lines have whole millivolts


class JoystickInput:
    """The two outputs of a converter (DAC) at the joystick's input of a chair, and what the chair does then."""

    def __init__(self, chair: DeflectionTable) -> None:
        """`chair`: its true curves."""
        self._chair = chair
        self.volts = self.neutral

    @property
    def neutral(self) -> tuple[float, float]:
        """[V] of drive and turn."""
        return self._chair.drive.neutral, self._chair.turn.neutral

    def set(self, drive: float, turn: float) -> bool:
        """Whether these [V] are neutral in both. Beyond the limits of one the outputs go to neutral."""
        fits = all(t.lowest <= v <= t.highest for t, v in ((self._chair.drive, drive), (self._chair.turn, turn)))
        self.volts = (drive, turn) if fits else self.neutral
        return max(abs(a - b) for a, b in zip(self.volts, self.neutral, strict=True)) <= _NEUTRAL

    def speeds(self) -> tuple[float, float]:
        """[m/s], [rad/s] that the chair would drive."""
        return self._speed(self._chair.drive, self.volts[0]), self._speed(self._chair.turn, self.volts[1])

    @staticmethod
    def _speed(table: AxisTable, volts: float) -> float:
        return float(np.interp(volts, table.volts, table.speeds))


class Firmware:
    """Times [s] by its own clock, which begins with it. With `joystick` it obeys voltages, and no speeds."""

    def __init__(
        self,
        wheels: WheelSettings,
        *,
        name: str = "simulated",
        version: int = VERSION,
        joystick: JoystickInput | None = None,
    ) -> None:
        self._wheels, self._identity, self.joystick = wheels, Identity(version, name), joystick
        self._lines = Lines()
        self._wanted = [0.0, 0.0]  # [m/s] of the left and right wheel
        self.speeds = [0.0, 0.0]
        self._ways = [0.0, 0.0]  # [m]
        self._heard, self._sequence = -math.inf, -1
        self.power = False
        self.emergency_stop = False  # the button
        self._let_go = False  # zero was commanded since it was pressed, and since the start
        self.contact, self.charging = False, False  # the charger's voltage is there; its current flows
        self._said, self._now = -math.inf, 0.0
        self._out = [encode(self._identity.text())]

    def receive(self, data: bytes) -> None:
        """Bytes from the computer."""
        for message in self._lines.feed(data):
            if message == ASK:
                self._out.append(encode(self._identity.text()))
            elif isinstance(message, Command | Deflection) and message.sequence != self._sequence:
                self._hear(message)

    def _hear(self, message: Message) -> None:
        if isinstance(message, Deflection) and self.joystick is not None:
            zero = self.joystick.set(message.drive, message.turn)
            self._obey(message, self.joystick.speeds(), zero)
        elif isinstance(message, Command) and self.joystick is None:
            self._obey(message, (message.v, message.omega), message.v == message.omega == 0.0)

    def _obey(self, command: Command | Deflection, speeds: tuple[float, float], zero: bool) -> None:
        """What comes with the power, or without it, moves nothing yet."""
        self._heard, self._sequence = self._now, command.sequence
        had_power, self.power = self.power, command.power
        self._let_go = self._let_go or (not self.emergency_stop and zero)
        half = 0.5 * self._wheels.separation * speeds[1]
        drives = had_power and self.power and self._let_go
        self._wanted = [speeds[0] - half, speeds[0] + half] if drives else [0.0, 0.0]
        if not drives:
            self._neutral()

    def _neutral(self) -> None:
        if self.joystick is not None:
            self.joystick.set(*self.joystick.neutral)

    def step(self, now: float) -> bytes:
        """Drive until `now`; returns what is to be sent."""
        elapsed, self._now = now - self._now, now
        silent = now - self._heard > SILENCE
        if self.emergency_stop:
            self.power = self._let_go = False
        if silent or self.emergency_stop:
            self._wanted = [0.0, 0.0]
            self._neutral()
        if silent:
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
        states |= {Flags.CONTACT: self.contact, Flags.CHARGING: self.charging}
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
