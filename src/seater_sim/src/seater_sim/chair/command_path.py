"""How a command comes to the motor controller: late, not equally late, and not at all when it is too small."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from seater_common.geometry import Limits
from seater_sim.settings import CommandSettings, to_ns
from seater_sim.settings.wheelchair import OFFSET


def deadband(command: float, width: float, kind: str) -> float:
    """What a command [m/s or rad/s] is worth: up to `width` nothing; above it all (`jump`) or the rest (`offset`)."""
    if abs(command) <= width:
        return 0.0
    return math.copysign(abs(command) - width, command) if kind == OFFSET else command


class CommandPath:
    """Delay with jitter, time-out, deadband and gain; speeds in m/s and rad/s, times in ns."""

    def __init__(self, settings: CommandSettings, limits: Limits, seed: int) -> None:
        self._settings, self._limits = settings, limits
        self._delay_ns, self._jitter_ns = to_ns(settings.delay), to_ns(settings.delay_jitter)
        self._timeout_ns = to_ns(settings.timeout)
        self._seed = seed
        self._pending: deque[tuple[int, float, float]] = deque()
        self._acting: tuple[int, float, float] | None = None

    def push(self, v: float, omega: float, now_ns: int) -> bool:
        """A command arrives; one that is not finite counts as zero, and False is returned."""
        finite = math.isfinite(v) and math.isfinite(omega)
        if not finite:
            v = omega = 0.0
        limits = self._limits
        v = min(max(v, -limits.v_reverse_max), limits.v_max)
        omega = min(max(omega, -limits.omega_max), limits.omega_max)
        due = now_ns + self._delay_ns
        if self._jitter_ns:
            # By the time, not one after another: how many zeros come before a goal depends on the machine.
            due += int(np.random.default_rng([self._seed, 3, now_ns]).random() * self._jitter_ns)
        self._pending.append((due, v, omega))  # one wire: a later command waits for the one before it
        return finite

    def at(self, now_ns: int) -> tuple[float, float]:
        """(v, omega) that the motor controller is to reach now."""
        while self._pending and self._pending[0][0] <= now_ns:
            self._acting = self._pending.popleft()
        if self._acting is None or now_ns - self._acting[0] >= self._timeout_ns:
            return 0.0, 0.0
        s, (_, v, omega) = self._settings, self._acting
        v = s.gain_v * deadband(v, s.deadband_v, s.deadband_kind)
        return v, s.gain_omega * deadband(omega, s.deadband_omega, s.deadband_kind)

    def clear(self) -> None:
        """Forget all commands."""
        self._pending.clear()
        self._acting = None
