"""The camera's geometry is shared by simulation, control and evaluation: seater_common.camera_model."""

from seater_common.camera_model import COEFFICIENTS, CameraModel

__all__ = ["COEFFICIENTS", "CameraModel"]
