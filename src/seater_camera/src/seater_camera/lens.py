"""Whose calibration counts, and that it is one of these images."""

from __future__ import annotations

from seater_common.camera_model import CameraModel


class WrongSizeError(ValueError):
    """Image and calibration, or image and what was asked for, have not one size."""


def choose(file: CameraModel | None, device: CameraModel | None) -> tuple[CameraModel | None, str]:
    """The lens, and where it is from: a calibration file before what the device says of itself."""
    if file is not None:
        return file, "calibration file"
    return device, "none" if device is None else "device"


def check_size(lens: CameraModel | None, origin: str, width: int, height: int) -> None:
    """Raises WrongSizeError, naming both sizes."""
    if lens is not None and (lens.width, lens.height) != (width, height):
        raise WrongSizeError(
            f"images have {width} x {height} pixels, the calibration ({origin}) {lens.width} x {lens.height}: "
            "set format/width and format/height of camera.yaml to its size, or calibrate anew"
        )
