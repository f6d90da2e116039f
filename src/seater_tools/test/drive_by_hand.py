"""A drive made without the code under test: arcs of circles, OpenCV's projection, matrices written out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np

from seater_common.camera_model import CameraModel
from seater_common.geometry import CameraMount, Dock, Marker
from seater_tools.drive.drive import Drive

K = np.array([[640.0, 0.0, 639.5], [0.0, 642.0, 359.5], [0.0, 0.0, 1.0]])
D = np.array([-0.05, 0.01, 0.0005, -0.0003, 0.0])
CAMERA = CameraModel(1280, 720, "plumb_bob", D, K, np.eye(3), np.zeros((3, 4)))
TRACK = 0.56  # [m]
# (v [m/s], omega [rad/s], duration [s]): near and back, turns to both sides, again.
TURNS = [(0.0, 0.4, 1.2), (0.0, -0.4, 2.4), (0.0, 0.4, 1.2)]
DRIVE = [(0.25, 0.0, 7.6), (-0.25, 0.0, 5.2), *TURNS, (0.25, 0.0, 5.2), (-0.25, 0.0, 2.0), *TURNS, (-0.25, 0.0, 3.0)]


@dataclass(frozen=True)
class Truth:
    """How things are; markers as rows (id, size, x, y, z, yaw, tilt, roll)."""

    mount: tuple[float, ...] = (0.475, -0.022, 0.715, 0.03, -0.02, 0.04)
    markers: tuple[tuple[float, ...], ...] = (
        (0, 0.1015, 0.905, 0.012, 0.71, 3.10, 0.008, -0.004),
        (1, 0.1477, 0.888, 0.338, 0.693, -3.11, -0.006, 0.005),
        (2, 0.1525, 0.910, -0.361, 0.704, 3.13, 0.003, 0.009),
    )
    scale: float = 0.012
    heading_scale: float = -0.015
    heading_drift: float = 0.004
    noise: float = 0.05  # [px]
    radii: tuple[float, float] = (0.0, 0.0)  # left and right wheel: so much larger than the odometry believes
    start: tuple[float, float, float] = (-2.35, 0.06, 0.02)
    moves: list[tuple[float, float, float]] = field(default_factory=lambda: list(DRIVE))

    @property
    def dock(self) -> Dock:
        return Dock(markers=[Marker(int(r[0]), r[1], list(r[2:5]), r[5]) for r in self.markers])

    @property
    def camera_mount(self) -> CameraMount:
        return CameraMount(*self.mount)


def rotation(axis: str, angle: float) -> np.ndarray:
    vector = np.zeros(3)
    vector["xyz".index(axis)] = angle
    return cv2.Rodrigues(vector)[0]


def corners_of(row: tuple[float, ...], pose: np.ndarray, mount: tuple[float, ...]) -> np.ndarray:
    """(4, 2) [px] of a marker from a pose of base_link."""
    _, size, x, y, z, yaw, tilt, roll = row
    # A print that faces along x of the dock: its x axis is the dock's y, its y axis is up.
    facing = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    R_dock_marker = rotation("z", yaw) @ facing @ rotation("x", tilt) @ rotation("z", roll)
    square = 0.5 * size * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]])
    in_dock = square @ R_dock_marker.T + [x, y, z]
    in_base = (in_dock - [pose[0], pose[1], 0.0]) @ rotation("z", pose[2])
    R_base_body = rotation("z", mount[5]) @ rotation("y", mount[4]) @ rotation("x", mount[3])
    in_body = (in_base - mount[:3]) @ R_base_body
    optical = np.column_stack([-in_body[:, 1], -in_body[:, 2], in_body[:, 0]])
    return cv2.projectPoints(optical, np.zeros(3), np.zeros(3), K, D)[0].reshape(-1, 2)


def make_drive(truth: Truth, seed: int = 1) -> Drive:
    """Odometry at 50 Hz and images at 5 Hz; markers wholly in the image are seen."""
    rng = np.random.default_rng(seed)
    pose, odom = np.array(truth.start), np.array([3.0, -1.0, 0.7])
    odometry, seen = [[0.0, *odom]], []
    time, step = 0.0, 0.02
    for v, omega, duration in truth.moves:
        for _ in range(round(duration / step)):
            pose = arc(pose, v * step, omega * step)
            turn = omega * step * (1.0 + truth.heading_scale) + truth.heading_drift * v * step
            odom = arc(odom, *measured(v * step * (1.0 + truth.scale), turn, truth.radii))
            time += step
            odometry.append([time, *odom])
            if round(time / step) % 10 == 0:
                seen += [(time, int(row[0]), corners_of(row, pose, truth.mount)) for row in truth.markers]
    inside = [s for s in seen if np.all(s[2] > 3.0) and np.all(s[2] < [1276.0, 716.0])]
    stamps = np.array(sorted({s[0] for s in inside}))
    corners = np.array([s[2] + truth.noise * rng.standard_normal((4, 2)) for s in inside])
    covariance = np.tile(truth.noise**2 * np.eye(8), (len(inside), 1, 1))
    image, ids = np.searchsorted(stamps, [s[0] for s in inside]), np.array([s[1] for s in inside])
    return Drive(np.array(odometry), stamps, image, ids, corners, covariance)


def measured(way: float, turn: float, radii: tuple[float, float]) -> tuple[float, float]:
    """Way and turn as wheels of these radii tell them."""
    left = (way - 0.5 * TRACK * turn) / (1.0 + radii[0])
    right = (way + 0.5 * TRACK * turn) / (1.0 + radii[1])
    return 0.5 * (left + right), (right - left) / TRACK


def arc(pose: np.ndarray, way: float, turn: float) -> np.ndarray:
    middle = pose[2] + 0.5 * turn
    return pose + [way * math.cos(middle), way * math.sin(middle), turn]
