"""Messages that arrive after their stamp, in their order."""

from __future__ import annotations

from collections import deque

import numpy as np

from seater_sim.chair.interface import OdometrySample


class Arrivals:
    """Holds each odometry message back by a random time of up to `jitter_ns`; none overtakes another."""

    def __init__(self, jitter_ns: int, seed: int) -> None:
        self._jitter_ns = jitter_ns
        self._rng = np.random.default_rng([seed, 7])
        self._on_the_way: deque[tuple[int, OdometrySample]] = deque()

    def send(self, sample: OdometrySample) -> None:
        """It leaves at its stamp."""
        due = sample.time_ns
        if self._jitter_ns:
            due += int(self._rng.random() * self._jitter_ns)
        self._on_the_way.append((due, sample))

    def receive(self, now_ns: int) -> OdometrySample | None:
        """The message that arrives in this step; at most one, so those that come together arrive step by step."""
        if self._on_the_way and self._on_the_way[0][0] <= now_ns:
            return self._on_the_way.popleft()[1]
        return None
