"""Where the adjustment begins: images that say something, and about where the chair was."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock, planar_pose
from seater_common.se2 import compose, inverse, wrap_angle
from seater_tools.drive.drive import FEWEST_IMAGES, Drive, DriveError
from seater_tools.mount.path import Path

Array = NDArray[np.float64]

NEW = (0.004, 0.005)  # [m], [rad] of way and turn that make another image worth taking
FAR = (0.5, 0.35)  # [m], [rad] a pose from one image that is so far off the others is a flip


def known_part(drive: Drive, dock: Dock) -> Drive:
    """Markers that the dock file has, images within the odometry's time. Raises DriveError: too little is left."""
    known = np.isin(drive.ids, [marker.id for marker in dock.markers])
    if not np.any(known):
        seen = ", ".join(map(str, sorted(set(drive.ids.tolist()))))
        raise DriveError(f"the drive shows markers {seen}, the dock file has none of them")
    rows = drive.without(~known)
    begin, end = drive.odometry[0, 0], drive.odometry[-1, 0]
    inside = (drive.stamps >= begin) & (drive.stamps <= end)
    return rows.chosen(np.intersect1d(np.flatnonzero(inside), rows.image))


def spread_images(drive: Drive, most: int) -> Drive:
    """At most so many, evenly over way and turn: where the chair stands, one image is as good as many.

    Raises DriveError: the chair hardly moved.
    """
    effort = np.concatenate([[0.0], np.cumsum(Path(drive).effort @ (1.0 / np.array(NEW)))])
    if effort[-1] < FEWEST_IMAGES:
        raise DriveError(
            "the chair hardly moves while the camera sees markers: drive straight to and fro, and turn on the spot"
        )
    count = int(min(most, effort[-1]))
    wanted = np.linspace(0.0, effort[-1], count)
    return drive.chosen(np.unique(np.searchsorted(effort, wanted).clip(0, len(effort) - 1)))


def first_poses(drive: Drive, camera: CameraModel, mount: CameraMount, dock: Dock) -> Array:
    """(images, 3) of base_link in the dock frame: the odometry, laid where most images see the dock."""
    path = Path(drive).poses(np.zeros(6))
    T_base_optical = mount.T_base_optical()
    docks = []
    for image, pose in enumerate(path):
        T_optical_dock = _dock_in_camera(drive, image, camera, dock)
        if T_optical_dock is not None:
            docks.append(compose(pose, planar_pose(T_base_optical @ T_optical_dock)))
    if not docks:
        raise DriveError("no image gives a pose of the dock: are the markers' ids and places those of the dock file?")
    found = np.array(docks)
    middle = np.array([*np.median(found[:, :2], axis=0), _median_angle(found[:, 2])])
    turned = np.abs([wrap_angle(float(angle - middle[2])) for angle in found[:, 2]])
    near = (np.hypot(*(found[:, :2] - middle[:2]).T) < FAR[0]) & (turned < FAR[1])
    if np.any(near):
        heading = middle[2] + np.median([wrap_angle(float(angle - middle[2])) for angle in found[near, 2]])
        middle = np.array([*np.median(found[near, :2], axis=0), heading])
    T_dock_odom = inverse(middle)
    poses = np.array([compose(T_dock_odom, pose) for pose in path])
    poses[:, 2] = np.unwrap(poses[:, 2])
    return poses


def _median_angle(angles: Array) -> float:
    reference = float(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum()))
    return reference + float(np.median([wrap_angle(float(angle) - reference) for angle in angles]))


def _dock_in_camera(drive: Drive, image: int, camera: CameraModel, dock: Dock) -> Array | None:
    """T_optical_dock (4, 4) from all corners of an image, with the file's places; None: no solution."""
    markers = {marker.id: marker for marker in dock.markers}
    points, pixels = [], []
    for row in np.flatnonzero(drive.image == image):
        marker = markers[int(drive.ids[row])]
        T = marker.T_dock_marker()
        points.append(marker.corners() @ T[:3, :3].T + T[:3, 3])
        pixels.append(drive.corners[row])
    rays = camera.ray(np.concatenate(pixels))
    if not np.all(np.isfinite(rays)):
        return None
    solved, r, t = cv2.solvePnP(np.concatenate(points), rays, np.eye(3), np.zeros(4), flags=cv2.SOLVEPNP_SQPNP)
    if not solved:
        return None
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(r)[0], t.ravel()
    return T
