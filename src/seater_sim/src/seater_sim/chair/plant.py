"""The ideal chair (plant `kinematic`): a unicycle behind a motor controller.

Each axis (speed, turning rate): the command acts after a delay; the demand follows it within the acceleration limit;
the true speed follows the demand as a first-order lag. Between two instants the demand is a ramp and then constant, so
the lag is solved in closed form, and the chair drives an arc of a circle with the mean speeds of the step.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Limits
from seater_common.se2 import arc_step
from seater_sim.chair.interface import Motion
from seater_sim.settings import NANOSECONDS, KinematicSettings, to_ns

Array = NDArray[np.float64]

# Below this a chair whose demand is zero stands: friction. [m/s] and [rad/s]
STANDSTILL = 1e-5


class Axis:
    """One motor axis: demand and true speed, in m/s or rad/s."""

    def __init__(self, lag: float, rate: float) -> None:
        self.lag = lag
        self.rate = rate
        self.demand = 0.0
        self.speed = 0.0

    def advance(self, target: float, duration: float) -> float:
        """Drive towards `target` for `duration` [s]; returns the way (integral of the true speed), exactly."""
        ramp = min(duration, abs(target - self.demand) / self.rate)
        way = 0.0
        if ramp > 0.0:
            way += self._follow(math.copysign(self.rate, target - self.demand), ramp)
        if ramp < duration:
            self.demand = target
            way += self._follow(0.0, duration - ramp)
        if self.demand == 0.0 and target == 0.0 and abs(self.speed) < STANDSTILL:
            self.speed = 0.0
        return way

    def brake(self, deceleration: float, duration: float) -> float:
        """Slow down by `deceleration` [m/s^2 or rad/s^2], whatever the motor is to do; returns the way."""
        before = self.speed
        slowing = min(abs(before), deceleration * duration)
        self.demand = self.speed = before - math.copysign(slowing, before)
        return 0.5 * (before + self.speed) * duration

    def stop(self) -> None:
        """Stalled: the motor stands and starts again from zero."""
        self.demand = self.speed = 0.0

    def _follow(self, slope: float, duration: float) -> float:
        """First-order lag behind a demand that changes by `slope` per second."""
        end = self.demand + slope * duration
        way = duration * 0.5 * (self.demand + end)
        if self.lag > 0.0:
            transient = self.speed - self.demand + slope * self.lag
            after = end - slope * self.lag + transient * math.exp(-duration / self.lag)
            way -= self.lag * (after - self.speed)
            self.speed = after
        else:
            self.speed = end
        self.demand = end
        return way


class KinematicPlant:
    """Pose and speeds of the chair; see interface.Plant. Time is counted in nanoseconds from the construction."""

    def __init__(self, settings: KinematicSettings, limits: Limits, pose: ArrayLike) -> None:
        """`pose`: (x [m], y [m], heading [rad]) of base_link in the dock frame."""
        self.limits = limits
        self.pose: Array = np.array(pose, dtype=float)
        if self.pose.shape != (3,) or not np.all(np.isfinite(self.pose)):
            raise ValueError(f"pose: is {pose!r}, must be three finite numbers")
        self.time_ns = 0
        self.refused = 0  # commands that were not finite
        self.motion = Motion()
        self._linear = Axis(settings.lag_v, limits.a_max)
        self._angular = Axis(settings.lag_omega, limits.alpha_max)
        self._delay_ns = to_ns(settings.command_delay)
        self._timeout_ns = to_ns(settings.command_timeout)
        self._pending: deque[tuple[int, float, float]] = deque()
        self._acting: tuple[int, float, float] | None = None
        self._pose_before = self.pose
        self._powered = True

    @property
    def v(self) -> float:
        """True speed [m/s]."""
        return self._linear.speed

    @property
    def omega(self) -> float:
        """True turning rate [rad/s]."""
        return self._angular.speed

    @property
    def target(self) -> tuple[float, float]:
        """(v, omega) that acts at this instant, after delay, limits and time-out."""
        if self._acting is None or self.time_ns - self._acting[0] >= self._timeout_ns:
            return 0.0, 0.0
        return self._acting[1], self._acting[2]

    def command(self, v: float, omega: float) -> bool:
        """Take a command that arrives now. One that is not finite counts as zero; then False is returned."""
        finite = math.isfinite(v) and math.isfinite(omega)
        if not finite:
            self.refused += 1
            v = omega = 0.0
        limits = self.limits
        v = min(max(v, -limits.v_reverse_max), limits.v_max)
        omega = min(max(omega, -limits.omega_max), limits.omega_max)
        self._pending.append((self.time_ns + self._delay_ns, v, omega))
        return finite

    def step(self, duration_ns: int) -> None:
        """Advance by `duration_ns`. A command takes effect at the step that begins at or after its time."""
        while self._pending and self._pending[0][0] <= self.time_ns:
            self._acting = self._pending.popleft()
        v, omega = self.target
        duration = duration_ns / NANOSECONDS
        if self._powered:
            self.motion = Motion(self._linear.advance(v, duration), self._angular.advance(omega, duration))
        else:
            self._forget()
            limits = self.limits
            way, turn = self._linear.brake(limits.a_max, duration), self._angular.brake(limits.alpha_max, duration)
            self.motion = Motion(way, turn)
        self._pose_before = self.pose
        self.pose = arc_step(self.pose, self.motion.way, self.motion.turn, 1.0)
        self.time_ns += duration_ns

    def power(self, on: bool) -> None:
        """See interface.Plant: it brakes within the chair's limits."""
        self._powered = on

    def _forget(self) -> None:
        self._pending.clear()
        self._acting = None

    def halt(self) -> None:
        """Stand still at once and forget all commands."""
        self._forget()
        self._linear.stop()
        self._angular.stop()

    def block(self) -> None:
        """Undo the motion of the last step and stall: something stands in the way."""
        self.pose = self._pose_before
        self.motion = Motion()
        self._linear.stop()
        self._angular.stop()

    def pose_within(self, fraction: float) -> Array:
        """Pose at a fraction (0..1) of the last step, on its arc."""
        return arc_step(self._pose_before, self.motion.way, self.motion.turn, fraction)
