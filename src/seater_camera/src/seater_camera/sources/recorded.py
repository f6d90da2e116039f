"""A recorded stream: a video file, or a folder of images, played once at its own pace."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_camera.frames import Clock, EndOfStreamError, Frame
from seater_camera.settings import CameraSettings
from seater_common.params import ParameterError

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".tif", ".tiff")


class RecordedSource:
    """Its clock begins at 0 with the first image. It is played once: no image goes out twice."""

    clock_period = math.inf

    def __init__(self, settings: CameraSettings) -> None:
        """`device` is the file or folder, `format/rate` the pace of a folder, and of a video that tells none.

        Raises:
            ParameterError: there is no such file, or no image in it.
        """
        self._path = Path(settings.device).expanduser()
        self.name = f"recording {self._path}"
        self._rate = float(settings.format.rate)
        self._images: Iterator[NDArray[np.uint8]] = iter(())
        self._begin, self._count, self._opened = 0.0, 0, False
        if self._path.is_dir():
            self._files = sorted(p for p in self._path.iterdir() if p.suffix.lower() in IMAGES)
            if not self._files:
                raise ParameterError(f"{self._path}: has no image ({', '.join(IMAGES)})")
        elif not (settings.device and self._path.is_file()):
            raise ParameterError(f"device: is {settings.device!r}, must be a video file or a folder of images")

    def open(self) -> None:
        """From the first image on. Raises EndOfStreamError: it was opened before, or cannot be read."""
        if self._opened:
            raise EndOfStreamError(f"{self.name} has failed, and is not played again")
        self._opened, self._count = True, 0
        self._images = self._of_folder() if self._path.is_dir() else self._of_video()
        self._begin = time.monotonic()

    def read(self) -> Frame:
        """At its time. Raises EndOfStreamError."""
        image = next(self._images, None)
        if image is None:
            raise EndOfStreamError(f"{self.name} has ended after {self._count} images")
        seconds = self._count / self._rate
        self._count += 1
        time.sleep(max(0.0, self._begin + seconds - time.monotonic()))
        return Frame(image, seconds, Clock.DEVICE, time.monotonic())

    def close(self) -> None:
        """No further image."""
        self._images = iter(())

    def set_exposure(self, seconds: float | None) -> bool:
        """It is too late for another than the device's own."""
        return seconds is None

    def _of_folder(self) -> Iterator[NDArray[np.uint8]]:
        for file in self._files:
            image = cv2.imread(str(file), cv2.IMREAD_COLOR)
            if image is None:
                raise EndOfStreamError(f"{file}: cannot be read as an image")
            yield np.asarray(image)

    def _of_video(self) -> Iterator[NDArray[np.uint8]]:
        video = cv2.VideoCapture(str(self._path))
        if not video.isOpened():
            raise EndOfStreamError(f"{self._path}: cannot be read as a video")
        rate = video.get(cv2.CAP_PROP_FPS)
        self._rate = rate if 0.1 < rate < 1000.0 else self._rate
        while (found := video.read())[0]:
            yield np.asarray(found[1])
        video.release()
