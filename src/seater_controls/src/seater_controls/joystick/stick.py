"""What a joystick asks for. No device and no clock: events and times [s] come in."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from seater_controls.settings import AxisSettings, JoystickSettings


@dataclass(frozen=True)
class Wish:
    """Of the person, now."""

    v: float  # [m/s]
    omega: float  # [rad/s]
    hold: bool
    why: str  # it asks for nothing, in words; empty: it does, or is let go


class Stick:
    """Neutral, and hold-to-run let go, from the start, when unplugged, silent, or beyond its range; then the stick has
    to be at neutral, and each button up, once before it counts again. So has the stick at neutral when the dead-man's
    button is pressed: pressing it never sets the chair moving.
    """

    def __init__(self, settings: JoystickSettings) -> None:
        self._settings = settings
        self._axes = {settings.drive.code: settings.drive, settings.turn.code: settings.turn}
        self._raw: dict[str, int] = {}
        self._pressed: set[str] = set()
        self._heard = -math.inf
        self._ready = self._hold_ready = False
        self._fault = "no joystick yet"

    def plugged(self, raw: Mapping[str, int], pressed: set[str], now: float) -> None:
        """It was opened, or events were lost: where everything is."""
        self._raw, self._pressed, self._heard = dict(raw), set(pressed), now
        self._ready = self._hold_ready = False
        self._fault = ""
        self._look()

    def unplugged(self, why: str) -> None:
        """It is gone."""
        self._raw, self._pressed, self._fault = {}, set(), why
        self._ready = self._hold_ready = False

    def event(self, code: str, value: int, now: float) -> None:
        """One axis or button; others are not looked at."""
        self._update(now)
        self._heard = now
        if code in self._axes:
            self._raw[code] = value
        elif code in (self._settings.dead_man, self._settings.hold):
            (self._pressed.add if value else self._pressed.discard)(code)
        self._look()

    def wish(self, now: float) -> Wish:
        """At `now`."""
        self._update(now)
        why = self._fault or self._beyond() or self._not_yet(now)
        if why:
            return Wish(0.0, 0.0, self._held and not (self._fault or self._beyond()), why)
        s = self._settings
        forward, left = self._share(s.drive), self._share(s.turn)
        return Wish(forward * (s.v_forward if forward > 0.0 else s.v_backward), left * s.omega, self._held, "")

    @property
    def _held(self) -> bool:
        return self._hold_ready and self._settings.hold in self._pressed

    @property
    def _dead_man(self) -> bool:
        return not self._settings.dead_man or self._settings.dead_man in self._pressed

    def _update(self, now: float) -> None:
        if self._silent(now):
            self._ready = self._hold_ready = False

    def _silent(self, now: float) -> bool:
        return 0.0 < self._settings.silence < now - self._heard

    def _look(self) -> None:
        """What follows from where everything is now."""
        if self._fault or self._beyond():
            self._ready = self._hold_ready = False
            return
        self._hold_ready = self._hold_ready or self._settings.hold not in self._pressed
        neutral = self._share(self._settings.drive) == 0.0 == self._share(self._settings.turn)
        if not self._dead_man:
            self._ready = False
        elif neutral:
            self._ready = True

    def _not_yet(self, now: float) -> str:
        if self._silent(now):
            return "silent"
        if not self._dead_man:
            return "the dead-man's button is up"
        return "" if self._ready else "it has not been at neutral yet"

    def _beyond(self) -> str:
        for code, axis in self._axes.items():
            if code not in self._raw:
                return f"{code} is not known"
            if abs(_position(axis, self._raw[code])) > 1.0 + self._settings.beyond:
                return f"{code} is {self._raw[code]}, beyond {axis.negative} .. {axis.positive}: calibrate it"
        return ""

    def _share(self, axis: AxisSettings) -> float:
        """-1 to 1 beyond the deadband."""
        position = _position(axis, self._raw[axis.code])
        beyond = min(abs(position), 1.0) - self._settings.deadband
        return math.copysign(beyond / (1.0 - self._settings.deadband), position) if beyond > 0.0 else 0.0


def _position(axis: AxisSettings, raw: int) -> float:
    """-1 and 1 at the ends, 0 at the centre."""
    way = raw - axis.centre
    positive = axis.positive - axis.centre
    return way / positive if way * positive > 0 else -way / (axis.negative - axis.centre)
