"""Markers for rviz out of the messages of perception and obstacles, and of the files of chair and dock."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import Point, Pose, Quaternion
from numpy.typing import ArrayLike, NDArray
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from seater_common.geometry import Chair, Dock, planar_pose, pose_matrix, quaternion_of
from seater_common.messages import matrix_of_pose
from seater_common.se2 import transform_points

Array = NDArray[np.float64]

SIGMAS = 2.0  # half axes of the ellipsoids
SMALLEST = 0.001  # [m] rviz draws nothing thinner
LIFETIME = rospy.Duration(0.5)  # of what one image shows
PLATE = 0.005  # [m] thickness of a print
LINE = 0.015  # [m]
WALL, PRINT, DOCKED = (0.5, 0.57, 0.65, 0.6), (0.95, 0.95, 0.95, 1.0), (0.7, 0.75, 0.8, 1.0)
SEEN, CANDIDATE, OBSTACLE = (1.0, 0.77, 0.24), (0.5, 0.7, 1.0), (1.0, 0.35, 0.3, 1.0)


def everything_gone(header: Header) -> Marker:
    """Takes away what was drawn before on the same topic."""
    return Marker(header=header, action=Marker.DELETEALL, pose=Pose(orientation=Quaternion(w=1.0)))


def dock_markers(frame: str, chair: Chair, dock: Dock) -> MarkerArray:
    """Walls, prints and the docked footprint, fixed in the dock's frame."""
    header = Header(frame_id=frame)  # stamp 0: with every new transform
    found = []
    for outline in dock.bay.outlines():
        low, high = outline.min(axis=0), outline.max(axis=0)
        T = np.eye(4)
        T[:3, 3] = [*(low + high) / 2.0, dock.bay.wall_height / 2.0]
        found.append(_shape(header, "bay", Marker.CUBE, T, [*(high - low), dock.bay.wall_height], WALL))
    for marker in dock.markers:
        size = [marker.size, marker.size, PLATE]
        found.append(_shape(header, "prints", Marker.CUBE, marker.T_dock_marker(), size, PRINT))
    found.append(_outline(header, "docked", chair.corners_at(dock.docked_pose), DOCKED))
    return _numbered(found, locked=True)


def seen_markers(header: Header, T_base_optical: Array, message: Any, dock: Dock) -> MarkerArray:
    """What one image shows (seater_msgs/MarkerDetectionArray): each marker with the ellipsoid of its covariance, and
    the bay at each possible pose of the dock. `header`: base_link at the stamp of the image."""
    found = [everything_gone(header)]
    for seen in message.markers:
        T = T_base_optical @ matrix_of_pose(seen.pose.pose)
        covariance = np.reshape(np.array(seen.pose.covariance, dtype=float), (6, 6))[:3, :3]
        R = T_base_optical[:3, :3]
        if not (np.all(np.isfinite(T)) and np.all(np.isfinite(covariance))):
            continue
        found.append(_shape(header, "markers", Marker.CUBE, T, [seen.size, seen.size, PLATE], (*SEEN, 0.9)))
        found.append(_ellipsoid(header, T[:3, 3], R @ covariance @ R.T))
        found.append(_label(header, T[:3, 3] + [0.0, 0.0, 0.75 * seen.size], str(seen.id)))
    for seen in message.dock:
        T = T_base_optical @ matrix_of_pose(seen.pose.pose)
        if np.all(np.isfinite(T)) and math.isfinite(seen.weight):
            found += _candidate(header, planar_pose(T), dock, seen.weight)
    return _numbered(found, lifetime=LIFETIME)


def obstacle_markers(message: Any, dock_frame: str) -> MarkerArray:
    """The outlines of a seater_msgs/ObstacleArray, in its frame; in the dock's they follow the dock."""
    bound = message.header.frame_id == dock_frame
    header = Header(frame_id=dock_frame) if bound else message.header
    found = [everything_gone(header)]
    for polygon in message.polygons:
        corners = np.array([(corner.x, corner.y) for corner in polygon.points], dtype=float).reshape(-1, 2)
        if len(corners) and np.all(np.isfinite(corners)):
            found.append(_outline(header, "outlines", corners, OBSTACLE))
    return _numbered(found, locked=bound)


def point_marker(message: Any) -> Marker:
    """The points of a seater_msgs/ObstaclePoints, in its frame."""
    marker = _shape(
        message.header, f"points of {message.source}", Marker.POINTS, np.eye(4), [0.03, 0.03, 0.0], OBSTACLE
    )
    pairs = zip(message.x, message.y, strict=False)
    marker.points = [Point(x, y, 0.0) for x, y in pairs if math.isfinite(x) and math.isfinite(y)]
    marker.lifetime = LIFETIME
    return marker


def _candidate(header: Header, pose: Array, dock: Dock, weight: float) -> list[Marker]:
    """The bay's walls and an arrow into it, fainter the less likely it is."""
    colour = (*CANDIDATE, min(1.0, max(0.1, weight)))
    arrow = _shape(header, "candidates", Marker.ARROW, pose_matrix(pose), [0.4, 0.03, 0.03], colour)
    walls = [_outline(header, "candidates", transform_points(pose, each), colour) for each in dock.bay.outlines()]
    return [arrow, *walls]


def _ellipsoid(header: Header, centre: ArrayLike, covariance: Array) -> Marker:
    values, vectors = np.linalg.eigh(covariance)
    if np.linalg.det(vectors) < 0.0:
        vectors[:, 0] *= -1.0
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = vectors, centre
    scale = np.maximum(2.0 * SIGMAS * np.sqrt(np.maximum(values, 0.0)), SMALLEST)
    return _shape(header, "covariances", Marker.SPHERE, T, scale, (*SEEN, 0.4))


def _label(header: Header, place: ArrayLike, text: str) -> Marker:
    T = np.eye(4)
    T[:3, 3] = place
    marker = _shape(header, "ids", Marker.TEXT_VIEW_FACING, T, [0.0, 0.0, 0.08], (*SEEN, 1.0))
    marker.text = text
    return marker


def _outline(header: Header, name: str, corners: Array, colour: Sequence[float]) -> Marker:
    """A closed line on the floor."""
    marker = _shape(header, name, Marker.LINE_STRIP, np.eye(4), [LINE, 0.0, 0.0], colour)
    marker.points = [Point(float(x), float(y), 0.0) for x, y in [*corners, corners[0]]]
    return marker


def _shape(header: Header, name: str, kind: int, T: Array, scale: Iterable[float], colour: Sequence[float]) -> Marker:
    marker = Marker(header=header, ns=name, type=kind, action=Marker.ADD, color=ColorRGBA(*colour))
    marker.pose.position = Point(*map(float, T[:3, 3]))
    marker.pose.orientation = Quaternion(*quaternion_of(T[:3, :3]))
    marker.scale.x, marker.scale.y, marker.scale.z = map(float, scale)
    return marker


def _numbered(markers: list[Marker], *, locked: bool = False, lifetime: rospy.Duration | None = None) -> MarkerArray:
    for number, marker in enumerate(markers):
        marker.id, marker.frame_locked = number, locked
        marker.lifetime = lifetime or rospy.Duration(0)
    return MarkerArray(markers)
