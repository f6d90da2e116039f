"""Reads a source for ever: opens it anew when it fails, and delivers each good image once."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_camera.clock.stamps import RefusedError, Stamper
from seater_camera.exposure import ExposureController, Light
from seater_camera.frames import EndOfStreamError, Frame, Source, SourceError
from seater_camera.health import Health
from seater_camera.lens import WrongSizeError, check_size, choose
from seater_camera.settings import CameraSettings
from seater_common.camera_model import CameraModel

_FIRST_PAUSE, _LONGEST_PAUSE = 0.5, 5.0  # [s] before the source is opened anew

Deliver = Callable[[NDArray[np.uint8], float, CameraModel | None], None]


class Stream:
    """One source, one thread.

    `deliver(image, stamp, lens)` gets each image in the encoding asked for, its stamp [s] of ROS time, and the lens
    (None: not known).
    """

    def __init__(
        self,
        source: Source,
        settings: CameraSettings,
        stamper: Stamper,
        deliver: Deliver,
        *,
        lens: CameraModel | None = None,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        """`lens`: of the calibration file, which counts before the device's."""
        self._source, self._settings, self._stamper, self._deliver = source, settings, stamper, deliver
        self._file, self._steady = lens, steady
        self._lens: CameraModel | None = lens
        self._stop = threading.Event()
        self.lens_origin = "none yet"
        self.health = Health(settings.format.rate, steady())
        by_prints = settings.exposure.mode == "prints"
        self.exposure = ExposureController(settings.exposure) if by_prints else None
        self.exposure_works = True  # the device takes what is wanted

    def stop(self) -> None:
        """`run` returns after the frame that it waits for."""
        self._stop.set()

    def run(self) -> None:
        """Until `stop`, or the end of a recording."""
        pause = _FIRST_PAUSE
        while not self._stop.is_set():
            before = self.health.total_images
            try:
                self._connect()
                while not self._stop.is_set():
                    self._take(self._source.read())
            except EndOfStreamError as end:
                self.health.failed(str(end))
                return
            except (SourceError, WrongSizeError) as error:
                self.health.failed(str(error))
            finally:
                self._source.close()
            pause = _FIRST_PAUSE if self.health.total_images > before else min(2.0 * pause, _LONGEST_PAUSE)
            self._stop.wait(pause)

    def _connect(self) -> None:
        device = self._source.open()
        self._lens, self.lens_origin = choose(self._file, device)
        self._stamper.connected(self._source.clock_period)
        self._begin_exposure()
        self.health.connected()

    def _begin_exposure(self) -> None:
        settings = self._settings.exposure
        wanted = self.exposure.time if self.exposure is not None else settings.time
        self.exposure_works = self._source.set_exposure(None if settings.mode == "device" else wanted)

    def _take(self, frame: Frame) -> None:
        height, width = frame.image.shape[:2]
        check_size(self._lens, self.lens_origin, width, height)
        try:
            stamp = self._stamper.stamp(frame)
        except RefusedError as error:
            self.health.refused(error.refusal)
            return
        self._deliver(_encoded(frame.image, self._settings.format.encoding), stamp, self._lens)
        now = self._steady()
        self.health.published(stamp, self._stamper.age(stamp), now)
        self._expose(frame.image, now)

    def _expose(self, image: NDArray[np.uint8], now: float) -> None:
        if self.exposure is None or not self.exposure_works or not self.exposure.due(now):
            return
        wanted = self.exposure.decide(Light.of(image), now)
        if wanted is not None:
            self.exposure_works = self._source.set_exposure(wanted)


def _encoded(image: NDArray[np.uint8], encoding: str) -> NDArray[np.uint8]:
    if encoding == "mono8" and image.ndim == 3:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
    if encoding == "bgr8" and image.ndim == 2:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR))
    return image
