"""In the place of OpenCV's VideoCapture and of pyrealsense2, with as much of them as the sources use."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np


class Capture:
    """A V4L2 camera as OpenCV shows it. `times` are those of the next images' buffers [s]; none left: unplugged."""

    def __init__(self, size: tuple[int, int] = (64, 48), times: list[float] | None = None, there: bool = True) -> None:
        self.there, self.times, self.controls = there, list(times or []), {}  # type: ignore[var-annotated]
        self._size, self._now, self.released = size, 0.0, False

    def __call__(self, device: str, api: int) -> Capture:
        assert api == cv2.CAP_V4L2
        return self

    def isOpened(self) -> bool:
        return self.there

    def set(self, what: int, value: float) -> bool:
        self.controls[what] = value
        return True

    def get(self, what: int) -> float:
        size = {cv2.CAP_PROP_FRAME_WIDTH: self._size[0], cv2.CAP_PROP_FRAME_HEIGHT: self._size[1]}
        return 1e3 * self._now if what == cv2.CAP_PROP_POS_MSEC else size.get(what, 0.0)

    def read(self) -> tuple[bool, Any]:
        if not self.times:
            return False, None
        self._now = self.times.pop(0)
        return True, np.full((self._size[1], self._size[0], 3), 7, np.uint8)

    def release(self) -> None:
        self.released = True


class Sensor:
    def __init__(self) -> None:
        self.options: dict[str, float] = {}

    def supports(self, option: str) -> bool:
        return option != "auto_exposure_priority"

    def get_option_range(self, option: str) -> Any:
        return SimpleNamespace(min=0.0, max=10000.0)

    def set_option(self, option: str, value: float) -> None:
        self.options[option] = value

    def get_stream_profiles(self) -> list[Any]:
        return [SimpleNamespace(unique_id=lambda: 7)]


class RealSense:
    """The module. `frames` are (time [ms], domain); none left: unplugged."""

    stream = SimpleNamespace(color="color")
    format = SimpleNamespace(bgr8="bgr8")
    timestamp_domain = SimpleNamespace(hardware_clock="hardware", global_time="global", system_time="system")
    option = SimpleNamespace(
        exposure="exposure",
        enable_auto_exposure="enable_auto_exposure",
        auto_exposure_priority="auto_exposure_priority",
    )

    def __init__(self, frames: list[tuple[float, str]], model: str = "distortion.inverse_brown_conrady") -> None:
        self.frames, self.sensor, self.asked, self.running = list(frames), Sensor(), [], False  # type: ignore[var-annotated]
        self.intrinsics = SimpleNamespace(
            width=64, height=48, fx=50.0, fy=51.0, ppx=32.0, ppy=24.0, model=model, coeffs=[0.0] * 5
        )

    def config(self) -> Any:
        return SimpleNamespace(
            enable_device=lambda serial: self.asked.append(serial), enable_stream=lambda *a: self.asked.append(a)
        )

    def pipeline(self) -> RealSense:
        return self

    def start(self, config: Any) -> Any:
        if not self.frames:
            raise RuntimeError("No device connected")
        self.running = True
        stream = SimpleNamespace(unique_id=lambda: 7, get_intrinsics=lambda: self.intrinsics)
        device = SimpleNamespace(query_sensors=lambda: [self.sensor])
        profile = SimpleNamespace(as_video_stream_profile=lambda: stream)
        return SimpleNamespace(get_stream=lambda kind: profile, get_device=lambda: device)

    def stop(self) -> None:
        self.running = False

    def wait_for_frames(self, timeout: int) -> Any:
        if not self.frames:
            raise RuntimeError(f"Frame didn't arrive within {timeout}")
        stamp, domain = self.frames.pop(0)
        frame = SimpleNamespace(
            get_frame_timestamp_domain=lambda: domain,
            get_timestamp=lambda: stamp,
            get_data=lambda: np.full((48, 64, 3), int(time.monotonic() * 1e3) % 255, np.uint8),
        )
        return SimpleNamespace(get_color_frame=lambda: frame)
