"""Intel RealSense cameras, by pyrealsense2 (PyPI); the colour stream."""

from __future__ import annotations

import importlib
import math
import time
from typing import Any

import numpy as np

from seater_camera.frames import Clock, Frame, SourceError
from seater_camera.settings import CameraSettings
from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError

_UNIT = 1e-4  # [s] of the colour sensor's exposure
_PERIOD = 2**32 * 1e-6  # [s]: the device counts microseconds in 32 bits


def load_library() -> Any:
    """pyrealsense2. Raises ParameterError: it is not installed, and how it is."""
    try:
        return importlib.import_module("pyrealsense2")
    except ImportError as error:
        raise ParameterError(
            f"RealSense cameras need pyrealsense2 ({error}): .venv/bin/pip install -r tools/requirements_realsense.txt"
        ) from error


def devices() -> list[tuple[str, str]]:
    """Serial number and name of each RealSense. Raises ParameterError as load_library."""
    rs = load_library()
    info = rs.camera_info
    return [(d.get_info(info.serial_number), d.get_info(info.name)) for d in rs.context().query_devices()]


class RealsenseSource:
    """Frames carry the wall clock's time as librealsense maps it ("global time": it asks the device for its time, so
    the way over USB is known), else the device's own time.
    """

    clock_period = _PERIOD

    def __init__(self, settings: CameraSettings, rs: Any = None, context: Any = None) -> None:
        """`rs`: the library. `context`: of librealsense, with a simulated device in tests.

        Raises:
            ParameterError: pyrealsense2 is not installed.
        """
        self._rs = rs if rs is not None else load_library()
        self._context, self._settings = context, settings
        self.name = f"RealSense {settings.device}".strip()
        self._pipeline: Any = None
        self._sensor: Any = None

    def open(self) -> CameraModel | None:
        """The lens as calibrated in the factory. Raises SourceError."""
        self.close()
        rs, wanted = self._rs, self._settings.format
        config = rs.config()
        if self._settings.device:
            config.enable_device(self._settings.device)
        config.enable_stream(rs.stream.color, wanted.width, wanted.height, rs.format.bgr8, wanted.rate)
        pipeline = rs.pipeline() if self._context is None else rs.pipeline(self._context)
        try:
            profile = pipeline.start(config)
            self._pipeline = pipeline
            stream = profile.get_stream(rs.stream.color).as_video_stream_profile()
            self._sensor = _sensor_of(profile, stream)
            self._set_option(rs.option.auto_exposure_priority, 0.0)  # else the dark slows the images down
            return _lens(stream.get_intrinsics())
        except RuntimeError as error:
            self.close()
            raise SourceError(
                f"{self.name} cannot be opened ({error}): is it plugged into USB 3, the udev rule installed, and "
                f"{wanted.width} x {wanted.height} at {wanted.rate} Hz one of its formats? (camera_node --list)"
            ) from error

    def read(self) -> Frame:
        """Raises SourceError: unplugged, or no image within `timeout`."""
        try:
            frame = self._pipeline.wait_for_frames(round(1e3 * self._settings.timeout)).get_color_frame()
        except RuntimeError as error:
            raise SourceError(f"{self.name} gives no more images ({error}): is it plugged in?") from error
        arrival = time.monotonic()
        if not frame:
            raise SourceError(f"{self.name} gives images without colour")
        own = frame.get_frame_timestamp_domain() == self._rs.timestamp_domain.hardware_clock
        image = np.array(frame.get_data(), dtype=np.uint8)  # a copy: the library uses its memory again
        return Frame(image, frame.get_timestamp() / 1e3, Clock.DEVICE if own else Clock.WALL, arrival)

    def close(self) -> None:
        """Stop the pipeline; a device that is gone makes it complain."""
        pipeline, self._pipeline, self._sensor = self._pipeline, None, None
        if pipeline is not None:
            try:
                pipeline.stop()
            except RuntimeError:
                return

    def set_exposure(self, seconds: float | None) -> bool:
        """Of the colour sensor."""
        option = self._rs.option
        if seconds is None:
            return self._set_option(option.enable_auto_exposure, 1.0)
        manual = self._set_option(option.enable_auto_exposure, 0.0)
        return manual and self._set_option(option.exposure, seconds / _UNIT)

    def _set_option(self, option: Any, value: float) -> bool:
        """False: the sensor has no such option. Raises SourceError: it is gone."""
        if self._sensor is None or not self._sensor.supports(option):
            return False
        try:
            limits = self._sensor.get_option_range(option)
            self._sensor.set_option(option, float(np.clip(value, limits.min, limits.max)))
        except RuntimeError as error:
            raise SourceError(f"{self.name} does not take its exposure ({error})") from error
        return True


def _sensor_of(profile: Any, stream: Any) -> Any:
    """The sensor whose stream it is; None: not found."""
    for sensor in profile.get_device().query_sensors():
        if any(p.unique_id() == stream.unique_id() for p in sensor.get_stream_profiles()):
            return sensor
    return None


def _lens(found: Any) -> CameraModel | None:
    """None: librealsense's distortion, which has other formulas than OpenCV's, is not 0."""
    if not (found.fx > 0.0 and math.isfinite(found.fx)):
        return None
    values = {
        "image_width": found.width,
        "image_height": found.height,
        "distortion_model": str(found.model),
        "distortion_coefficients": {"data": list(found.coeffs)},
        "camera_matrix": {"data": [found.fx, 0.0, found.ppx, 0.0, found.fy, found.ppy, 0.0, 0.0, 1.0]},
    }
    try:
        return CameraModel.from_mapping(values, "RealSense intrinsics")
    except ParameterError:
        return None
