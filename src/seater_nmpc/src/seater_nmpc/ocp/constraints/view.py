"""The camera's field of view, in which one of the markers is kept."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_common.geometry import CameraMount, Chair, Dock
from seater_common.se2 import transform_points
from seater_common.sight import Sight, marker_edges
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Slack, Stage
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]
Point = tuple[float, float, float]

# [rad] half of a horizontal field of view that nearly every camera has (a Raspberry Pi camera 2: 0.54).
UNKNOWN_CAMERA = 0.45
# [rad] kept from the image's edges beside what the detector needs: the turn of one control cycle (0.8 rad/s, 50 ms).
TURN_RESERVE = 0.04
_SAME_PLACE = 0.05  # [m] markers that differ by less in their distance from the axis are equally good


def kept_field(camera: CameraModel | None, half_angle: float) -> FieldOfView:
    """Where in the image a marker is to be kept.

    Args:
        camera: None: not known; then `half_angle` counts or, without it, UNKNOWN_CAMERA.
        half_angle: control/view_half_angle [rad]: at most so far to both sides; 0: as far as the camera sees.
    """
    if camera is None:
        return FieldOfView.symmetric(half_angle or UNKNOWN_CAMERA)
    field = FieldOfView.of(camera).narrowed(TURN_RESERVE)
    return field.limited(half_angle) if half_angle > 0.0 else field


@dataclass(frozen=True)
class View:
    """Two points (of whichever frame; the height is above the floor) [m] that the camera is to keep in sight.

    `left`: the right end of the leftmost marker; it stays inside the right edge of the view. `right`: the left end of
    the rightmost marker; it stays inside the left edge. Then one marker at least is wholly in view, as far as the view
    is as wide as the gaps between them.
    """

    left: Point
    right: Point
    camera: CameraModel | None = None

    def transformed(self, change: Array) -> View:
        """See Area."""
        (x_left, y_left), (x_right, y_right) = transform_points(change, [self.left[:2], self.right[:2]]).tolist()
        return View((x_left, y_left, self.left[2]), (x_right, y_right, self.right[2]), self.camera)

    def constraint(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> ViewConstraint:
        """See Area."""
        field = kept_field(self.camera, parameters.view_half_angle)
        return ViewConstraint(chair.camera, field, (self.left[2], self.right[2]), programme)


def markers_to_keep(dock: Dock, mount: CameraMount | None = None, camera: CameraModel | None = None) -> View:
    """In the dock's frame: the ends of all markers of an open dock, else of those nearest to the dock's axis.

    Side walls hide an outer marker from half of all ways into the bay, and then it is of no use in the image. With a
    mount given, only those count that the docked chair sees, where it sees any: no other can be kept to the end.
    """
    chosen = kept_markers(dock, mount, camera)
    ends = [marker_edges(dock, index) for index in chosen]
    left = max((right for _, right in ends), key=lambda end: float(end[1]))
    right = min((left for left, _ in ends), key=lambda end: float(end[1]))
    return View(_point(left), _point(right), camera)


def kept_markers(dock: Dock, mount: CameraMount | None = None, camera: CameraModel | None = None) -> list[int]:
    """Indices of the markers that `markers_to_keep` means."""
    chosen = list(range(len(dock.markers)))
    if dock.bay.side_wall_length > 0.0:
        if mount is not None:
            seen = Sight(mount, dock, kept_field(camera, 0.0)).seen(np.zeros((1, 3)))[0]
            chosen = np.flatnonzero(seen).tolist() or chosen
        off_axis = [abs(dock.markers[index].position[1]) for index in chosen]
        chosen = [i for i, off in zip(chosen, off_axis, strict=True) if off <= min(off_axis) + _SAME_PLACE]
    return chosen


def _point(end: Array) -> Point:
    x, y, z = end.tolist()
    return x, y, z


def sideways_edges(field: FieldOfView, mount: CameraMount) -> tuple[Array, Array]:
    """The planes (4,) of the view that bound it to the chair's left and to its right (see FieldOfView.edges).

    They are the image's left and right edges, or those above and below where the camera stands on its side: turning the
    chair moves the markers across them. The two others are what start-up checks: the chair cannot look up or down.
    """
    edges = field.edges(mount)
    # Turning by a small angle moves a point straight ahead of the camera along this direction.
    c, s = math.cos(mount.yaw), math.sin(mount.yaw)
    aside = edges[:, :3] @ np.array([-s, c, 0.0])
    return edges[int(np.argmin(aside))], edges[int(np.argmax(aside))]


class ViewConstraint(AreaConstraint[View]):
    """View.right inside the left edge and View.left inside the right edge of the field of view."""

    slack = Slack.VIEW

    def __init__(
        self, mount: CameraMount, field: FieldOfView, heights: tuple[float, float], programme: StageProgramme
    ) -> None:
        """`heights` [m] of the left and the right point above the floor."""
        super().__init__()
        self._yaw = mount.yaw
        left, right = sideways_edges(field, mount)
        self._edges = ((right, heights[0]), (left, heights[1]))
        self._p, self._where = programme.parameter("view", 4)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint. Across the line of sight [m]."""
        c, s = ca.cos(stage.pose[2]), ca.sin(stage.pose[2])
        margins = []
        for i, (edge, height) in enumerate(self._edges):
            a, b, vertical, d = edge.tolist()
            dx, dy = self._p[2 * i] - stage.pose[0], self._p[2 * i + 1] - stage.pose[1]
            margins.append(a * (c * dx + s * dy) + b * (c * dy - s * dx) + (vertical * height + d))
        return [ca.vertcat(*margins)]

    def set_instance(self, area: View, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint."""
        p[self._where] = [*area.left[:2], *area.right[:2]]

    def looks_away(self, area: View, pose: Array) -> bool:
        """Whether the markers are behind the camera of a chair at `pose` (3,). Then nothing near the chair brings them
        into view, and the way to fewer metres outside it leads past them: backward into the bay."""
        heading = float(pose[2]) + self._yaw
        x, y = 0.5 * (np.array(area.left[:2]) + np.array(area.right[:2])) - pose[:2]
        return math.cos(heading) * x + math.sin(heading) * y < 0.0
