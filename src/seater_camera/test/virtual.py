"""A camera with a clock of its own, in simulated time: unplugs, stalls, repeats, and gives other sizes when told."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from seater_camera.frames import Clock, Frame, SourceError
from seater_common.camera_model import CameraModel

PERIOD = 1.0 / 30.0


class Time:
    """Two clocks of a host, which a test moves."""

    def __init__(self) -> None:
        self.steady, self.wall_offset = 5000.0, 1.7e9

    def wall(self) -> float:
        return self.steady + self.wall_offset


def picture(seed: int, height: int = 48, width: int = 64) -> NDArray[np.uint8]:
    """Of noise; another for each seed."""
    return np.random.default_rng(seed).integers(0, 255, (height, width, 3), dtype=np.uint8)


def lens(width: int = 64, height: int = 48) -> CameraModel:
    values = {
        "image_width": width,
        "image_height": height,
        "distortion_model": "plumb_bob",
        "distortion_coefficients": {"data": [0.0] * 5},
        "camera_matrix": {"data": [50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]},
    }
    return CameraModel.from_mapping(values, "lens")


class VirtualSource:
    """`script[n]` is what happens at the n-th read; it may raise, or change the frame. After `frames` reads it calls
    `at_end`. Every exposure is at a multiple of PERIOD of the time; arrivals come 20 ms and some jitter later."""

    name, clock_period = "virtual", float("inf")

    def __init__(
        self, time: Time, *, drift: float = 0.0, clock: Clock = Clock.DEVICE, device_lens: bool = True
    ) -> None:
        self.time, self.drift, self.clock = time, drift, clock
        self.script: dict[int, Callable[[Frame], Frame]] = {}
        self.reads, self.opened, self.is_open = 0, 0, False
        self.frames, self.at_end = 300, lambda: None
        self.exposures: list[float | None] = []
        self.taken: list[float] = []  # true times of exposure by the steady clock, of all frames
        self._random = np.random.default_rng(4)
        self._lens = lens() if device_lens else None

    def open(self) -> CameraModel | None:
        assert not self.is_open, "opened twice"
        self.opened += 1
        self.is_open = True
        return self._lens

    def close(self) -> None:
        self.is_open = False

    def read(self) -> Frame:
        assert self.is_open, "read while closed"
        taken = self.time.steady + 0.5 * PERIOD
        self.time.steady = taken + 0.020 + self._random.exponential(0.003)
        own = {
            Clock.DEVICE: (taken - 4000.0) * (1.0 - self.drift),
            Clock.MONOTONIC: taken,
            Clock.WALL: taken + self.time.wall_offset,
            Clock.ARRIVAL: 0.0,
        }[self.clock]
        frame = Frame(picture(self.reads), own, self.clock, self.time.steady)
        number, self.reads = self.reads, self.reads + 1
        self.taken.append(taken)
        if self.reads == self.frames:
            self.at_end()
        return self.script[number](frame) if number in self.script else frame

    def set_exposure(self, seconds: float | None) -> bool:
        self.exposures.append(seconds)
        return True


def unplugged(_: Frame) -> Frame:
    raise SourceError("unplugged")
