"""When the sensor of obstacles measures, and when it delivers."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_sim.ranging.sensor import RangeSensor
from seater_sim.settings import to_ns

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SimulatedRange:
    """A measurement that has been taken; `measure` computes it."""

    index: int
    stamp_ns: int
    pose: Array  # true pose of base_link in the dock frame at the stamp
    walkers: Array  # (n, 2) [m] in the dock frame, at the stamp
    seed: int
    sensor: RangeSensor

    def measure(self) -> Array:
        """See RangeSensor.measure."""
        return self.sensor.measure(self.pose, self.walkers, self.seed, self.index)


class Ranges:
    """The measurements of one run."""

    def __init__(self, sensor: RangeSensor | None, seed: int, start_ns: int) -> None:
        """`sensor`: None: there is none. `start_ns`: the clock at the start of the run."""
        self.sensor, self._seed, self._start_ns = sensor, seed, start_ns
        self._on_the_way: deque[SimulatedRange] = deque()

    def step(self, now_ns: int, pose: Array, walkers: Array) -> list[SimulatedRange]:
        """Measures when it is due at `now_ns` with chair and walkers there; what is delivered now."""
        if self.sensor is None:
            return []
        elapsed, period = now_ns - self._start_ns, to_ns(self.sensor.settings.period)
        if elapsed % period == 0:
            self._on_the_way.append(
                SimulatedRange(elapsed // period, now_ns, pose.copy(), walkers, self._seed, self.sensor)
            )
        delivered, latency = [], to_ns(self.sensor.settings.latency)
        while self._on_the_way and self._on_the_way[0].stamp_ns + latency <= now_ns:
            delivered.append(self._on_the_way.popleft())
        return delivered
