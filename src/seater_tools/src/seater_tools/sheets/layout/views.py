"""Where the markers hang: the dock seen by somebody who stands in front of the prints and looks at them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from seater_common.geometry import Dock, Marker
from seater_common.se2 import wrap_angle

SAME_WAY = 0.01  # [rad] markers that face the same way, within this, are drawn in one view


@dataclass(frozen=True)
class Place:
    """A marker in a view [mm]: right of the view's reference, above the floor."""

    marker: Marker
    x: float
    height: float

    @property
    def size(self) -> float:
        return 1000.0 * self.marker.size


@dataclass(frozen=True)
class View:
    """Markers that face one way. `turn`: 0 when they face straight out of the bay, positive towards the right of
    somebody who looks into it [rad]. x is measured along the paper from the middle of the back wall, to the right."""

    turn: float
    places: tuple[Place, ...]

    @property
    def title(self) -> str:
        if self.turn == 0.0:
            return "Front view, looking into the bay"
        return f"View of the markers that face {facing(self.turn)}"

    @property
    def reference(self) -> str:
        """What x = 0 is, when the view is square to the bay; else empty: nobody can put a rule there."""
        if self.turn == 0.0:
            return "middle of the bay"
        return "back wall" if abs(math.cos(self.turn)) < SAME_WAY else ""


def views_of(dock: Dock) -> list[View]:
    """One for each way that markers face, the one straight out of the bay first."""
    groups: dict[float, list[Marker]] = {}
    for marker in dock.markers:
        turn = turn_of(marker)
        known = next((known for known in groups if abs(wrap_angle(turn - known)) <= SAME_WAY), turn)
        groups.setdefault(known, []).append(marker)
    order = sorted(groups, key=abs)
    return [View(turn, tuple(_place(marker, dock) for marker in groups[turn])) for turn in order]


def turn_of(marker: Marker) -> float:
    """How far the print is turned from straight out of the bay, towards the right of who looks into it [rad]."""
    turn = float(wrap_angle(marker.normal_yaw - math.pi))
    return 0.0 if abs(turn) <= SAME_WAY else turn


def facing(turn: float) -> str:
    """In words, for somebody who looks into the bay."""
    if turn == 0.0:
        return "straight out"
    return f"{abs(math.degrees(turn)):.1f} deg to the {'right' if turn > 0 else 'left'}"


def _place(marker: Marker, dock: Dock) -> Place:
    right = marker.T_dock_marker()[:2, 0]
    offset = np.array([marker.position[0] - dock.bay.back_wall_x, marker.position[1]])
    return Place(marker, 1000.0 * float(right @ offset), 1000.0 * marker.position[2])
