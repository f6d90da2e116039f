"""A lens that is known with a standard deviation: what the drive may change of it.

A calibration leaves focal length and principal point uncertain by some hundredths of a percent and some tenths of a
pixel. Taken for exact, they put the camera millimetres elsewhere on the chair. So the lens is unknown, too: its
parameters are those of the calibration plus L z, where L L^T is their covariance, and z is normal of variance 1 before
the drive.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Lens:
    """`root`: (4 + coefficients, count), L; no column where the calibration does not say how certain it is."""

    camera: CameraModel
    root: Array

    @classmethod
    def of(cls, camera: CameraModel) -> Lens:
        """By the camera's own covariance."""
        if camera.covariance is None:
            return cls(camera, np.zeros((4 + len(camera.D), 0)))
        sd = np.sqrt(np.diag(camera.covariance))  # pixels and coefficients are of very different sizes
        values, vectors = np.linalg.eigh(camera.covariance / np.outer(sd, sd))
        return cls(camera, sd[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))

    @property
    def count(self) -> int:
        """Unknowns."""
        return self.root.shape[1]

    def at(self, off: Array) -> CameraModel:
        """The camera with `off` (count,), z above. The rectified image stays as it was."""
        if self.count == 0:
            return self.camera
        return self.camera.with_parameters(self.camera.parameters + self.root @ off)

    def found(self, off: Array, covariance: Array) -> CameraModel:
        """The same with the covariance that it has by the drive, of `off`: (count, count)."""
        return replace(self.at(off), covariance=self.root @ covariance @ self.root.T)
