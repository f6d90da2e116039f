"""What a camera on the chair can see: the image's edges as planes, seen from base_link."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, rotation_rpy

Array = NDArray[np.float64]

# [px] from a marker's corner to the image's edge that the detector needs: 3 px for the fit of the corner, and as much
# again for the blur of the edges that meet in it.
DETECTOR_BORDER = 6.0
_RIM_POINTS = 33  # per edge of the image at which the lens is asked


@dataclass(frozen=True)
class FieldOfView:
    """The largest upright rectangle within the image, as tangents of the angles from the optical axis to its edges."""

    left: float
    right: float
    up: float
    down: float

    @classmethod
    def of(cls, camera: CameraModel, border: float = DETECTOR_BORDER) -> FieldOfView:
        """`border` [px] inside the image. The lens bends the image's edges: of each, the point nearest to the axis
        counts, and where the distortion model has no inverse at an edge, the edge is taken farther inside.

        Raises:
            ValueError: the principal point is so near to an edge that nothing is left, or the distortion model has no
                inverse in the image's inner third either.
        """
        low, high = np.full(2, border), np.array([camera.width - 1.0, camera.height - 1.0]) - border
        for shrink in np.linspace(1.0, 0.3, 36):
            centre = camera.K[:2, 2]
            a, b = centre + shrink * (low - centre), centre + shrink * (high - centre)
            u, v = np.linspace(a[0], b[0], _RIM_POINTS), np.linspace(a[1], b[1], _RIM_POINTS)
            rims = [np.column_stack([np.full(_RIM_POINTS, edge), v]) for edge in (a[0], b[0])]
            rims += [np.column_stack([u, np.full(_RIM_POINTS, edge)]) for edge in (a[1], b[1])]
            rays = [camera.ray(rim) for rim in rims]
            if all(np.all(np.isfinite(ray)) for ray in rays):
                break
        else:
            raise ValueError("distortion_coefficients: the lens model has no inverse near the middle of the image")
        left, right = float(np.min(-rays[0][:, 0])), float(np.min(rays[1][:, 0]))
        up, down = float(np.min(-rays[2][:, 1])), float(np.min(rays[3][:, 1]))
        if not min(left, right, up, down) > 0.0:
            raise ValueError("camera_matrix: the principal point must lie inside the image, clear of its edges")
        return cls(left, right, up, down)

    @classmethod
    def symmetric(cls, half_angle: float) -> FieldOfView:
        """The same to both sides [rad], as high as one likes: of a camera about which no more is known."""
        return cls(math.tan(half_angle), math.tan(half_angle), math.inf, math.inf)

    def narrowed(self, angle: float) -> FieldOfView:
        """Each edge nearer to the axis by an angle [rad], at most by half of what there is."""

        def inner(edge: float) -> float:
            full = math.atan(edge)
            return math.tan(max(full - angle, 0.5 * full)) if math.isfinite(edge) else edge

        return FieldOfView(*(inner(edge) for edge in (self.left, self.right, self.up, self.down)))

    def limited(self, half_angle: float) -> FieldOfView:
        """At most this half-angle [rad] to the left and to the right."""
        edge = math.tan(half_angle)
        return replace(self, left=min(self.left, edge), right=min(self.right, edge))

    def edges(self, mount: CameraMount) -> Array:
        """(4, 4): each row (n, d) is a plane; a point p of base_link is on the seen side when n . p + d >= 0.

        In the order left, right, up, down of the image. The value is the distance across the line of sight [m], as
        large as the tangent's unit vector is long. A missing edge (infinite) is all zeros with d = 1.
        """
        R = rotation_rpy(mount.roll, mount.pitch, mount.yaw)  # columns: ahead, left, up of the camera body
        ahead, left, up = R.T
        rows = []
        for edge, side in ((self.left, -left), (self.right, left), (self.up, -up), (self.down, up)):
            if not math.isfinite(edge):
                rows.append(np.array([0.0, 0.0, 0.0, 1.0]))
                continue
            normal = edge * ahead + side
            rows.append(np.append(normal, -normal @ [mount.x, mount.y, mount.z]))
        return np.array(rows)
