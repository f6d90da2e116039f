"""The view from above, as plain lists that a page can draw.

Seen from the dock (x into the bay, y left) once it is known, else from the chair. Metres, rounded to millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import inverse, relative, transform_points
from seater_panel.view.heard import Heard, Outlines, Sight

Array = NDArray[np.float64]

FRESH = 0.5  # [s] sights and points older than this are not shown any more
PLAN_FRESH = 1.0  # [s]
MOST_POINTS = 200  # of a sensor of obstacles
SIGMAS = 2.0  # half axes of the ellipses


def scene(heard: Heard, chair: Chair, dock: Dock, now: float) -> dict[str, Any]:
    """Outlines as lists of [x, y]; `frame`: "dock" or "chair"; ellipses: half axes [m] and direction [rad]."""
    base = None if heard.motion is None else heard.motion.pose
    known = base is not None and heard.dock is not None
    frame, origin = ("dock", heard.dock) if known else ("chair", base)
    pose = relative(origin, base) if base is not None and origin is not None else np.zeros(3)
    found: dict[str, Any] = {"frame": frame, "chair": _points(chair.corners_at(pose)), "pose": _numbers(pose)}
    if frame == "dock":
        found["bay"] = [_points(outline) for outline in dock.bay.outlines()]
        found["docked"] = _points(chair.corners_at(dock.docked_pose))
        found["plates"] = [_plate(marker) for marker in dock.markers]
    found |= _seen(heard, origin, now)
    if heard.points is not None and now - heard.points.time <= FRESH:
        step = max(1, math.ceil(len(heard.points.points) / MOST_POINTS))
        found["points"] = _points(transform_points(pose, heard.points.points[::step]))
    return found


def ellipse(covariance: ArrayLike) -> tuple[float, float, float]:
    """Half axes (larger first) [m] and the larger one's direction [rad] of a covariance (2, 2) [m^2]."""
    values, vectors = np.linalg.eigh(np.asarray(covariance, dtype=float))
    small, large = SIGMAS * np.sqrt(np.maximum(values, 0.0))
    return float(large), float(small), math.atan2(vectors[1, 1], vectors[0, 1])


def _seen(heard: Heard, origin: Array | None, now: float) -> dict[str, Any]:
    """What is known in odom, from `origin`; nothing without one."""
    if origin is None:
        return {}
    to_view = inverse(origin)
    found: dict[str, Any] = {}
    if heard.planned is not None and now - heard.planned.time <= PLAN_FRESH:
        found["path"] = _points(transform_points(to_view, heard.planned.path))
    if heard.sights is not None and now - heard.sights.time <= FRESH:
        found["markers"] = [_sight(sight, to_view) for sight in heard.sights.markers]
        found["candidates"] = [
            {"pose": _numbers(relative(origin, pose)), "weight": round(weight, 3)}
            for pose, weight in heard.sights.candidates
        ]
    if heard.outlines is not None:
        place = _place(heard.outlines, heard.dock, origin)
        if place is not None:
            found["obstacles"] = [_points(transform_points(place, outline)) for outline in heard.outlines.polygons]
    return found


def _place(outlines: Outlines, dock: Array | None, origin: Array) -> Array | None:
    """The pose of their frame, seen from `origin`; None: nobody knows where the dock is that they belong to."""
    if not outlines.in_dock:
        return inverse(origin)
    return None if dock is None else relative(origin, dock)


def _plate(marker: Any) -> dict[str, Any]:
    """A printed marker from above: its two ends."""
    T = marker.T_dock_marker()
    ends = [T[:2, 3] + sign * 0.5 * marker.size * T[:2, 0] for sign in (-1.0, 1.0)]
    return {"id": marker.id, "ends": _points(ends)}


def _sight(sight: Sight, to_view: Array) -> dict[str, Any]:
    large, small, direction = ellipse(sight.covariance)
    place = transform_points(to_view, sight.place[None])[0]
    return {"id": sight.id, "at": _numbers(place), "axes": _numbers((large, small, direction + to_view[2]))}


def _points(points: Iterable[ArrayLike]) -> list[list[float]]:
    return [_numbers(point) for point in points if np.all(np.isfinite(np.asarray(point)))]


def _numbers(values: ArrayLike) -> list[float]:
    return [round(float(value), 4) for value in np.asarray(values, dtype=float)]
