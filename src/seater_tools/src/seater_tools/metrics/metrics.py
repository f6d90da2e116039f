"""What is counted and measured (docs/how-to/watch_the_dockings.md#prometheus). SI units, as Prometheus asks for."""

from __future__ import annotations

import functools
import math
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from prometheus_client import CollectorRegistry, Counter, Enum, Gauge, Histogram

from seater_nmpc.sequence.goal.results import ResultCode

SOLVES = 1000  # cycles of which quantiles are taken: 50 s
SECONDS = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 60.0, 90.0, 120.0, math.inf)  # upper edges of the histogram
QUANTILES = (0.5, 0.99)
UNKNOWN = "UNKNOWN"  # before the gate has said anything


class Metrics:
    """`clock`: [s], steady. Its methods may be called from any thread."""

    def __init__(self, registry: CollectorRegistry, clock: Callable[[], float], gate_states: dict[int, str]) -> None:
        """`gate_states`: names of the numbers of GateState."""
        self._clock, self._states = clock, gate_states
        self._lock, self._solves = threading.Lock(), deque[float](maxlen=SOLVES)
        self._image_at = self._dock_at = math.nan
        made: Any = {"registry": registry}
        self._goals = Counter("seater_goals", "Goals that have ended", ["action", "result"], **made)
        self._retries = Counter("seater_retries", "Further tries of dockings", **made)
        self._seconds = Histogram("seater_docking_seconds", "Time of dockings", buckets=SECONDS, **made)
        self._error = Gauge("seater_final_error_metres", "Estimate of the last docking", ["axis"], **made)
        self._heading = Gauge("seater_final_error_radians", "Heading, estimate of the last docking", **made)
        self._fallbacks = Counter("seater_fallbacks", "Control cycles without a new solution", **made)
        self._gate = Enum("seater_gate_state", "What the gate lets through",
                          states=[UNKNOWN, *gate_states.values()], **made)  # fmt: skip
        self._stop = Gauge("seater_emergency_stop", "1: it stops the chair", **made)
        image = Gauge("seater_image_age_seconds", "Since an image was searched", **made)
        image.set_function(lambda: self._clock() - self._image_at)
        dock = Gauge("seater_dock_age_seconds", "Since an image showed the dock", **made)
        dock.set_function(lambda: self._clock() - self._dock_at)
        solve = Gauge("seater_solve_seconds", f"Of the last {SOLVES} solves", ["quantile"], **made)
        for q in QUANTILES:
            solve.labels(f"{q:g}").set_function(functools.partial(self._quantile, q))

    def docked(self, code: int, duration: float, retries: int, error: tuple[float, float, float] | None) -> None:
        """A goal `dock` has ended; `error`: along [m], across [m], heading [rad]; None: not verified."""
        self._goals.labels("dock", _name(code)).inc()
        self._retries.inc(retries)
        if code == ResultCode.SUCCESS:
            self._seconds.observe(duration)
        if error is not None:
            for axis, value in zip(("along", "across"), error, strict=False):
                self._error.labels(axis).set(value)
            self._heading.set(error[2])

    def undocked(self, code: int) -> None:
        """A goal `undock` has ended."""
        self._goals.labels("undock", _name(code)).inc()

    def image(self, shows_dock: bool) -> None:
        """An image was searched."""
        self._image_at = self._clock()
        if shows_dock:
            self._dock_at = self._image_at

    def cycle(self, solve_time: float, solved: bool, fallback: bool) -> None:
        """A control cycle [s]."""
        self._fallbacks.inc(fallback)
        if solved:
            with self._lock:
                self._solves.append(solve_time)

    def gate(self, state: int, emergency_stop: bool) -> None:
        """As GateState has it."""
        self._gate.state(self._states.get(state, UNKNOWN))
        self._stop.set(emergency_stop)

    def _quantile(self, q: float) -> float:
        with self._lock:
            return float(np.quantile(list(self._solves), q)) if self._solves else math.nan


def _name(code: int) -> str:
    return ResultCode(code).name if code in set(map(int, ResultCode)) else str(code)
