"""Any camera that Linux knows (V4L2: USB, built in), by OpenCV."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2

from seater_camera.frames import Clock, Frame, SourceError
from seater_camera.settings import CameraSettings

_AUTO, _MANUAL = 3, 1  # V4L2_EXPOSURE_APERTURE_PRIORITY, V4L2_EXPOSURE_MANUAL
_UNIT = 1e-4  # [s] of V4L2_CID_EXPOSURE_ABSOLUTE
_NEAR = 5.0  # [s]: a time this near to a clock's is of this clock
_FOLDER = Path("/sys/class/video4linux")


def devices() -> list[tuple[str, str]]:
    """Path and name of each camera; the kernel lists further devices of a camera that give no images, too."""
    return [(f"/dev/{p.name}", (p / "name").read_text().strip()) for p in sorted(_FOLDER.glob("video*"))]


class V4l2Source:
    """OpenCV tells the time that the kernel gave to the image's buffer (CAP_PROP_POS_MSEC), by the steady clock as a
    rule. A read that gets no image takes OpenCV's 10 s, whatever `timeout` says.
    """

    clock_period = math.inf

    def __init__(self, settings: CameraSettings, capture: Callable[..., Any] = cv2.VideoCapture) -> None:
        """`capture`: OpenCV's class; tests give another."""
        self._device, self._format, self._make = settings.device or "/dev/video0", settings.format, capture
        self.name = f"V4L2 camera {self._device}"
        self._capture: Any = None
        self._clock: Clock | None = None  # of this connection

    def open(self) -> None:
        """Raises SourceError: it cannot be had, or not with these settings."""
        self.close()
        capture = self._make(self._device, cv2.CAP_V4L2)
        if not capture.isOpened():
            capture.release()
            raise SourceError(f"{self._device}: {_why_not(self._device)}")
        self._capture, self._clock = capture, None
        wanted = self._format
        if wanted.pixels != "any":
            capture.set(cv2.CAP_PROP_FOURCC, cv2.VideoWriter.fourcc(*wanted.pixels))
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, wanted.width)
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, wanted.height)
        capture.set(cv2.CAP_PROP_FPS, wanted.rate)
        size = int(capture.get(cv2.CAP_PROP_FRAME_WIDTH)), int(capture.get(cv2.CAP_PROP_FRAME_HEIGHT))
        if size != (wanted.width, wanted.height):
            self.close()
            raise SourceError(
                f"{self._device} gives {size[0]} x {size[1]} pixels, {wanted.width} x {wanted.height} are asked for "
                f"(`v4l2-ctl -d {self._device} --list-formats-ext` lists what it can)"
            )

    def read(self) -> Frame:
        """Raises SourceError: unplugged, or no image for 10 s."""
        try:
            good, image = self._capture.read()
        except cv2.error as error:
            raise SourceError(f"{self._device}: {error}") from error
        arrival = time.monotonic()
        if not good or image is None or image.size == 0:
            raise SourceError(f"{self._device} gives no more images: {_why_not(self._device)}")
        seconds = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
        if self._clock is None:  # by the first image, which is new; a later one may have waited for long
            self._clock = _clock_of(seconds, arrival)
        return Frame(image, seconds, self._clock, arrival)

    def close(self) -> None:
        """Release the device."""
        if self._capture is not None:
            self._capture.release()
            self._capture = None

    def set_exposure(self, seconds: float | None) -> bool:
        """By V4L2's controls of exposure."""
        if seconds is None:
            return bool(self._capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, _AUTO))
        manual = self._capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, _MANUAL)
        return bool(manual and self._capture.set(cv2.CAP_PROP_EXPOSURE, max(1, round(seconds / _UNIT))))


def _clock_of(seconds: float, arrival: float) -> Clock:
    """Drivers may use the steady clock (nearly all), the wall clock (uvcvideo by option), their own, or none."""
    if not seconds > 0.0:
        return Clock.ARRIVAL
    if abs(arrival - seconds) < _NEAR:
        return Clock.MONOTONIC
    return Clock.WALL if abs(time.time() - seconds) < _NEAR else Clock.DEVICE


def _why_not(device: str) -> str:
    if not os.path.exists(device):
        return "there is no such device; is the camera plugged in? (camera_node --list)"
    if not os.access(device, os.R_OK | os.W_OK):
        return "no permission: sudo usermod -aG video $USER, then log in anew"
    return "another program uses it, or it is no camera, or it stands still (camera_node --list, fuser -v)"
