"""What the motors are asked for: the contract of a base driver (docs/safety.md), by a clock that nobody can set."""

from __future__ import annotations

import math
from dataclasses import dataclass

from seater_base.settings import BaseSettings


@dataclass(frozen=True)
class Request:
    """For the motors, now."""

    v: float  # [m/s]
    omega: float  # [rad/s]
    power: bool
    why: str  # it does not drive, in words; empty: it does as it is told


class Commander:
    """All times [s] by the steady clock. Silence, or two who command, brake; without `motor_enable` there is no power.

    A command that came while the power was off never counts. After an emergency stop of the base, and after its start,
    somebody has to command zero once: what was driving does not drive on.
    """

    def __init__(self, settings: BaseSettings) -> None:
        self._settings = settings
        self._velocity, self._heard = (0.0, 0.0), -math.inf
        self._senders: dict[str, float] = {}  # who commanded when last
        self._on, self._power_heard = False, -math.inf
        self._powered_since = math.inf
        self._pressed, self._let_go = False, True  # the base's button; zero was commanded since
        self._sent, self._sent_at = (0.0, 0.0), -math.inf

    def velocity(self, v: float, omega: float, sender: str, now: float) -> None:
        """A message on cmd_vel; one that is not finite is like silence."""
        self._senders[sender] = now
        if math.isfinite(v) and math.isfinite(omega):
            s = self._settings
            self._velocity = _within(v, s.v_max), _within(omega, s.omega_max)
            self._heard = now
            self._let_go = self._let_go or (not self._pressed and self._velocity == (0.0, 0.0))

    def power(self, on: bool, now: float) -> None:
        """A message on motor_enable."""
        self._on, self._power_heard = on, now

    def emergency_stop(self, pressed: bool) -> None:
        """What the base says of its button."""
        self._pressed = pressed
        self._let_go = self._let_go and not pressed

    def base_started(self) -> None:
        """It was plugged in, or has started anew."""
        self._let_go = False

    def request(self, now: float) -> Request:
        """To be sent at `now`; call it `rate` times per second."""
        elapsed, self._sent_at = max(0.0, now - self._sent_at), now
        refusal = self._no_power(now)
        if refusal:
            self._powered_since, self._sent = math.inf, (0.0, 0.0)
            return Request(0.0, 0.0, False, refusal)
        self._powered_since = min(self._powered_since, now)
        why = self._no_command(now)
        self._sent = self._braked(elapsed) if why else self._velocity
        return Request(*self._sent, True, why)

    def _no_power(self, now: float) -> str:
        if self._power_heard == -math.inf:
            return "motor_enable has never been heard of"
        if now - self._power_heard > self._settings.silence:
            return "motor_enable is silent"
        if not self._on:
            return "motor_enable is false"
        return "the emergency stop of the base is pressed" if self._pressed else ""

    def _no_command(self, now: float) -> str:
        silence = self._settings.silence
        recent = sorted(sender for sender, at in self._senders.items() if now - at <= silence)
        if len(recent) > 1:
            return f"two command: {', '.join(recent)}"
        if not self._let_go:
            return "zero has not been commanded since the base was started, or its emergency stop pressed"
        if self._heard <= self._powered_since:
            return "no command since the power is on"
        return "cmd_vel is silent, or not finite" if now - self._heard > silence else ""

    def _braked(self, elapsed: float) -> tuple[float, float]:
        """Slower, along the same curve."""
        v, omega = self._sent
        fastest = max(abs(v), 0.5 * abs(omega))  # the wheels are about so far from the middle, at most
        if fastest <= 0.0:
            return 0.0, 0.0
        factor = max(0.0, 1.0 - self._settings.brake * elapsed / fastest)
        return v * factor, omega * factor


def _within(value: float, most: float) -> float:
    return min(max(value, -most), most)
