"""The bay from above: walls, markers, and the axle of the docked chair, which is the origin of the frame `dock`."""

from __future__ import annotations

import math
from collections.abc import Callable

from seater_common.geometry import Dock, Marker
from seater_tools.sheets.draw.dimensions import dimension_across, dimension_up
from seater_tools.sheets.draw.elevation import SCALES
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.layout.rect import Rect

Placing = Callable[[float, float], tuple[float, float]]  # from the dock frame [m] to the paper [mm]
LONGEST = 6.0  # [mm] of the arrow that says where a print faces


def draw_from_above(pen: Pen, dock: Dock, room: Rect) -> None:
    """The way into the bay leads upwards: the dock's x axis points up, its y axis to the left."""
    bay = dock.bay
    half = 1000.0 * (0.5 * bay.width + bay.wall_thickness)
    far = 1000.0 * (bay.back_wall_x + bay.wall_thickness)
    near = min(-150.0, 1000.0 * bay.entrance_x - 50.0, *(1000.0 * marker.position[0] for marker in dock.markers))
    half = max(half, *(1000.0 * abs(marker.position[1]) + 50.0 for marker in dock.markers))
    width, height = room.width - 30.0, room.height - 22.0
    scale = next((s for s in SCALES if 2 * half / s <= width and (far - near) / s <= height), SCALES[-1])
    middle, base = 0.5 * (room.x0 + room.x1), room.y0 + 14.0 - near / scale

    def at(x: float, y: float) -> tuple[float, float]:
        """From the dock frame [m] to the paper [mm]."""
        return middle - 1000.0 * y / scale, base + 1000.0 * x / scale

    for wall in bay.outlines():
        pen.polygon([at(x, y) for x, y in wall], grey=0.85)
    pen.line(at(near / 1000.0, 0.0), at(bay.back_wall_x, 0.0), dash=(4.0, 1.0, 0.7, 1.0))
    _draw_axle(pen, at(0.0, 0.0))
    _draw_lengths(pen, dock, at)
    for marker in dock.markers:
        _draw_print(pen, dock, marker, at)
    pen.text(room.x1, room.y1 - 3.0, f"1 : {scale:g}, lengths in mm", 8.0, "right")


def _draw_print(pen: Pen, dock: Dock, marker: Marker, at: Placing) -> None:
    """A marker from above, the way that it faces, and all ids that are at this place of the floor plan."""
    x, y = marker.position[0], marker.position[1]
    right = marker.T_dock_marker()[:2, 0] * 0.5 * marker.size
    ends = at(x + right[0], y + right[1]), at(x - right[0], y - right[1])
    pen.line(*ends, width=0.9)
    start = at(x, y)
    way = -math.sin(marker.normal_yaw), math.cos(marker.normal_yaw)
    tip = start[0] + LONGEST * way[0], start[1] + LONGEST * way[1]
    pen.line(start, tip, width=0.2)
    ids = ", ".join(str(other.id) for other in dock.markers if other.position[:2] == marker.position[:2])
    pen.text(tip[0], tip[1] - 3.0, f"id {ids}", 7.5, "middle", bold=True, clear=True)


def _draw_axle(pen: Pen, at: tuple[float, float]) -> None:
    pen.line((at[0] - 9.0, at[1]), (at[0] + 9.0, at[1]), width=0.6)
    pen.text(at[0] + 10.5, at[1] + 1.0, "driven axle of the", 7.5)
    pen.text(at[0] + 10.5, at[1] - 2.5, "docked chair", 7.5)


def _draw_lengths(pen: Pen, dock: Dock, at: Placing) -> None:
    bay = dock.bay
    left, wall = at(bay.entrance_x, 0.5 * bay.width), at(bay.back_wall_x, 0.5 * bay.width)
    right = at(bay.entrance_x, -0.5 * bay.width)
    if bay.side_wall_length > 0.0:
        dimension_across(pen, left[0], right[0], left[1] - 9.0, 1000.0 * bay.width)
        outer = at(0.0, 0.5 * bay.width + bay.wall_thickness)[0] - 5.0
        dimension_up(pen, outer, left[1], wall[1], 1000.0 * bay.side_wall_length)
    dimension_up(pen, at(0.0, 0.0)[0] - 5.0, at(0.0, 0.0)[1], wall[1], 1000.0 * bay.back_wall_x)
