"""A chair as it is (plant `wheelchair`): two driven rear wheels, two front castors, a floor that is not ideal.

    command -> delay, time-out, deadband, gain -> ramp, lag -> battery, weak side, castors, slope -> turning of wheels
    turning of wheels -> encoders
                      -> true radius, slip, true track -> arc on the floor, creep to the side

Same settings, start, seed and commands: same run, to the bit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Limits
from seater_common.se2 import arc_step, wrap_angle
from seater_sim.chair.castors import Castors
from seater_sim.chair.command_path import CommandPath
from seater_sim.chair.encoders import Encoders
from seater_sim.chair.floor import Floor
from seater_sim.chair.interface import Motion
from seater_sim.chair.motors import Drive
from seater_sim.settings import NANOSECONDS, WheelchairSettings

Array = NDArray[np.float64]


class WheelchairPlant:
    """Pose and speeds of the chair; see interface.Plant. `v` and `omega` are the means of the last step."""

    def __init__(self, settings: WheelchairSettings, limits: Limits, pose: ArrayLike, seed: int) -> None:
        """`pose`: (x [m], y [m], heading [rad]) of base_link in the dock frame; `seed`: of all that is random."""
        self.pose: Array = np.array(pose, dtype=float)
        if self.pose.shape != (3,) or not np.all(np.isfinite(self.pose)):
            raise ValueError(f"pose: is {pose!r}, must be three finite numbers")
        self.time_ns = 0
        self.refused = 0  # commands that were not finite
        self.motion = Motion()
        self.v = self.omega = 0.0
        self.castors = Castors(settings.castors, seed)
        self.encoders = Encoders(settings.wheels)
        self._settings = settings
        self._commands = CommandPath(settings.command, limits, seed)
        self._drive = Drive(settings.motor)
        self._floor = Floor(settings.floor, seed)
        self._pose_before = self.pose
        self._powered = True
        self._turned = (0.0, 0.0)  # by the wheels in the last step [m]

    def command(self, v: float, omega: float) -> bool:
        """Take a command that arrives now. One that is not finite counts as zero; then False is returned."""
        finite = self._commands.push(v, omega, self.time_ns)
        self.refused += not finite
        return finite

    def step(self, duration_ns: int) -> None:
        """Advance by `duration_ns`. A command takes effect at the step that begins at or after its time."""
        duration = duration_ns / NANOSECONDS
        v, omega = self._commands.at(self.time_ns)
        before = self._drive.linear.speed, self._drive.angular.speed
        if self._powered:
            way, turn = self._drive.advance(v, omega, duration)
        else:
            self._commands.clear()
            way, turn = self._drive.advance_unpowered(duration)
        self._pose_before = self.pose
        if self._drive.moving or way or turn:
            self._move(way, turn, before, duration)
        else:
            self._stand()
        self.time_ns += duration_ns

    def power(self, on: bool) -> None:
        """See interface.Plant. A relay acts at once: neither the delay of commands nor the motor controller matters."""
        self._powered = on

    def halt(self) -> None:
        """Stand still at once and forget all commands."""
        self._commands.clear()
        self._drive.stop()
        self.v = self.omega = 0.0

    def block(self) -> None:
        """Undo the motion of the last step and stall: something stands in the way."""
        self.pose = self._pose_before
        self.encoders.turn(-self._turned[0], -self._turned[1])
        self._drive.stop()
        self._stand()

    def pose_within(self, fraction: float) -> Array:
        """Pose at a fraction (0..1) of the last step, on its arc."""
        pose = arc_step(self._pose_before, self.motion.way, self.motion.turn, fraction)
        aside, heading = fraction * self.motion.side, float(pose[2])
        return pose + [-aside * math.sin(heading), aside * math.cos(heading), 0.0]

    def _stand(self) -> None:
        self.motion = Motion()
        self._turned = (0.0, 0.0)
        self.v = self.omega = 0.0

    def _move(self, way: float, turn: float, before: tuple[float, float], duration: float) -> None:
        wheels = self._settings.wheels
        against, aside = self._floor.gravity(float(self.pose[2]))
        change = self._drive.linear.speed - before[0], self._drive.angular.speed - before[1]
        mean, difference = change[0] / duration + against, 0.5 * wheels.track * change[1] / duration
        loads = mean - difference, mean + difference
        left, right = self._turn_wheels(way, turn, loads, (against, aside), duration)
        self._turned = (left, right)
        self.encoders.turn(left, right)
        left, right, side = self._floor.roll(
            left * (1.0 + wheels.radius_error_left), right * (1.0 + wheels.radius_error_right), loads, aside
        )
        way, turn = 0.5 * (left + right), (right - left) / (wheels.track * (1.0 + wheels.track_error))
        self.motion = Motion(way, turn, side)
        self.v, self.omega = way / duration, turn / duration
        self.castors.swing(way, turn)
        self.pose = _moved(self.pose, self.motion)

    def _turn_wheels(
        self, way: float, turn: float, loads: tuple[float, float], gravity: tuple[float, float], duration: float
    ) -> tuple[float, float]:
        """Ways of both wheels' circumferences at nominal radius [m], of the axes' way and turn."""
        motor, half = self._settings.motor, 0.5 * self._settings.wheels.track
        elapsed, direction = self.time_ns / NANOSECONDS, math.copysign(1.0, way)
        left = (way - half * turn) * self._drive.strength(elapsed, direction * loads[0]) * (1.0 - motor.weak_left)
        right = (way + half * turn) * self._drive.strength(elapsed, direction * loads[1]) * (1.0 - motor.weak_right)
        slope = self._floor.push(*gravity)
        speed, rate = 0.5 * (left + right) / duration, 0.5 * (right - left) / (half * duration)
        castors = self.castors.push(speed + slope[0], rate + slope[1])
        pushed, swerved = (castors[0] + slope[0]) * duration, half * (castors[1] + slope[1]) * duration
        return left + pushed - swerved, right + pushed + swerved


def _moved(pose: Array, motion: Motion) -> Array:
    """As se2.arc_step, then to the side; plain floats, which are several times faster for one pose."""
    x, y, heading = pose.tolist()
    half = 0.5 * motion.turn
    chord = motion.way * (math.sin(half) / half if half else 1.0)
    direction, end = heading + half, heading + motion.turn
    return np.array(
        [
            x + chord * math.cos(direction) - motion.side * math.sin(end),
            y + chord * math.sin(direction) + motion.side * math.cos(end),
            wrap_angle(end),
        ]
    )
