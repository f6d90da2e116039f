"""A chair with a delay, a lag and deadbands, driven by a controller."""

from __future__ import annotations

import math

import numpy as np

from seater_common.se2 import arc_step
from seater_nmpc.control.controller import DockingController
from seater_nmpc.drive.axis import AxisDrive

STEP = 0.01  # [s]


class SlowChair:
    """Commands act after `delay` [s], the motors follow with `lag` [s], and the axes are what the drives say."""

    def __init__(self, pose, delay: float, lag: float, v: AxisDrive | None = None, omega: AxisDrive | None = None):
        self.pose, self.v, self.omega, self.ticks = np.array(pose, dtype=float), 0.0, 0.0, 0
        self._delay, self._decay = round(delay / STEP), math.exp(-STEP / lag) if lag > 0.0 else 0.0
        self._lag = lag
        self.curvature = 0.0  # [rad/m] that it turns by itself
        self._way = self._turn = 0.0  # since the last measurement
        self._drives = (v or AxisDrive(), omega or AxisDrive())
        self._sent: dict[int, tuple[float, float]] = {}

    @property
    def now(self) -> float:
        return self.ticks * STEP

    def drive(self, command: tuple[float, float], seconds: float, controller: DockingController | None = None) -> None:
        """Asked for `command` from now on; the controller hears of mean speeds every 20 ms, as from encoders."""
        self._sent[self.ticks] = command
        for _ in range(round(seconds / STEP)):
            began = max((k for k in self._sent if k <= self.ticks - self._delay), default=None)
            asked = (0.0, 0.0) if began is None else self._sent[began]
            means = []
            for i, speed in enumerate((self.v, self.omega)):
                target = self._drives[i].effective(asked[i]) + (self.curvature * self.v if i == 1 else 0.0)
                means.append(target + (speed - target) * (1.0 - self._decay) * self._lag / STEP)
                speed = target + (speed - target) * self._decay
                self.v, self.omega = (speed, self.omega) if i == 0 else (self.v, speed)
            self.pose = arc_step(self.pose, *means, STEP)
            self.ticks += 1
            self._way, self._turn = self._way + means[0] * STEP, self._turn + means[1] * STEP
            if controller is not None and self.ticks % 2 == 0:
                controller.measured(self.now, self._way / (2 * STEP), self._turn / (2 * STEP))
                self._way = self._turn = 0.0
