"""Faults of the camera, and of what it looks at."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount
from seater_common.se2 import compose, inverse
from seater_sim.faults import kinds
from seater_sim.world.events import GOOD, NAN, NAN_CAMERA_INFO


class CameraFault:
    """One at a time; a new one replaces the last."""

    def __init__(self) -> None:
        self._kind: str = kinds.CLEAR
        self._values: tuple[float, ...] = ()

    def set(self, kind: str, values: tuple[float, ...]) -> None:
        """Begin a fault, or end it (`clear`); values as `kinds.read` gives them."""
        self._kind, self._values = kind, values

    @property
    def off(self) -> bool:
        """No image."""
        return self._kind == "off"

    @property
    def frozen(self) -> bool:
        """The last picture again."""
        return self._kind == "frozen"

    @property
    def black(self) -> bool:
        """The lens is covered."""
        return self._kind == "black"

    @property
    def covered(self) -> bool:
        """The markers are."""
        return self._kind == "cover"

    @property
    def mode(self) -> str:
        """As SimulatedImage has it."""
        return {"nan": NAN, "nan_camera_info": NAN_CAMERA_INFO}.get(self._kind, GOOD)

    @property
    def period(self) -> float:
        """[s] at least from one image to the next."""
        return self._values[0] if self._kind == "slow" else 0.0

    @property
    def delay(self) -> float:
        """[s] beside the camera's own."""
        return self._values[0] if self._kind == "late" else 0.0

    def seen_from(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        """Pose of base_link in the frame of the dock as it stands now, for one in the frame where it stood, (3,)."""
        if self._kind != "dock_moved":
            return pose
        x, y, heading = self._values
        return compose(inverse(np.array([x, y, math.radians(heading)])), pose)

    def mount(self, mount: CameraMount) -> CameraMount:
        """Where the camera looks now."""
        if self._kind != "knocked":
            return mount
        yaw, pitch = map(math.radians, self._values)
        return replace(mount, yaw=mount.yaw + yaw, pitch=mount.pitch + pitch)

    def lens(self, model: CameraModel) -> CameraModel:
        """Through which it looks, whatever camera_info says."""
        if self._kind == "zoomed":
            return replace(model, K=_scaled(model.K, self._values[0]), P=_scaled(model.P, self._values[0]))
        if self._kind != "shifted":
            return model
        K, P = model.K.copy(), model.P.copy()
        K[:2, 2] += self._values
        P[:2, 2] += self._values
        return replace(model, K=K, P=P)

    def told(self, model: CameraModel) -> CameraModel:
        """What camera_info says."""
        if self._kind == "resized":
            return _resized(model, self._values[0])
        if self._kind == "nan_distortion":
            return replace(model, D=np.array([math.nan, *model.D[1:]]))
        if self._kind != "focal":
            return model
        return replace(model, K=_scaled(model.K, self._values[0]), P=_scaled(model.P, self._values[0]))


def _scaled(matrix: NDArray[np.float64], factor: float) -> NDArray[np.float64]:
    """K (3, 3) or P (3, 4) with other focal lengths, the principal point where it was."""
    result = matrix.copy()
    result[[0, 1], [0, 1]] *= factor
    return result


def _resized(model: CameraModel, factor: float) -> CameraModel:
    """The same lens before a sensor of so many times the pixels along each side."""
    K, P = model.K.copy(), model.P.copy()
    K[:2], P[:2] = factor * K[:2], factor * P[:2]
    return replace(model, width=round(factor * model.width), height=round(factor * model.height), K=K, P=P)
