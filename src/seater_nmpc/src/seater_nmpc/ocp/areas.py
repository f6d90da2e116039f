"""What the chair has to respect at a dock: prohibited areas, a zone to drive slowly in, points to keep in view."""

from __future__ import annotations

from dataclasses import dataclass, fields

from numpy.typing import ArrayLike

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock
from seater_common.se2 import inverse
from seater_nmpc.ocp.constraints.bay_speed import BayEntrance
from seater_nmpc.ocp.constraints.corners import Corners, side_wall_corners
from seater_nmpc.ocp.constraints.interface import Area
from seater_nmpc.ocp.constraints.view import View, markers_to_keep
from seater_nmpc.ocp.constraints.walls import HalfPlane, Walls


@dataclass(frozen=True)
class Areas:
    """One area of each kind, all in one frame (the dock's, or after `in_frame` another one's).

    Each field becomes a soft constraint of every stage; their order is that of the constraints in the programme.
    """

    walls: Walls
    corners: Corners
    entrance: BayEntrance
    view: View

    @property
    def parts(self) -> tuple[Area, ...]:
        """The areas in the order of the fields."""
        return tuple(getattr(self, field.name) for field in fields(self))

    def in_frame(self, pose: ArrayLike) -> Areas:
        """The same areas seen from the frame that has this pose (x, y, heading)."""
        change = inverse(pose)
        return Areas(*(part.transformed(change) for part in self.parts))  # type: ignore[arg-type]


def dock_areas(dock: Dock, mount: CameraMount | None = None, camera: CameraModel | None = None) -> Areas:
    """The bay's walls and speed limit, and the markers to keep in view, in the dock's frame.

    `mount` and `camera` of the chair's camera; None: not known.
    """
    bay = dock.bay
    return Areas(
        Walls((HalfPlane(0.0, bay.back_wall_x),)),
        side_wall_corners(bay),
        BayEntrance(HalfPlane(0.0, bay.entrance_x)),
        markers_to_keep(dock, mount, camera),
    )
