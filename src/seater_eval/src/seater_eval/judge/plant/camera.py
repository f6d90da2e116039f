"""What the camera sees of the dock's markers, and the poses that perception makes of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, Marker, pose_matrix
from seater_common.se2 import compose, inverse, transform_points
from seater_eval.judge.plant.effects import Pictures
from seater_eval.judge.plant.installation import Installation
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight

Array = NDArray[np.float64]
Pose = tuple[float, float, float]

_NEAREST = 0.15  # [m]
_SIDES = 40.0  # sides of a marker from which on it is too small in the image
_STEEPEST = math.radians(75.0)  # between line of sight and the print's normal
# Standard deviations at a distance d [m] from the camera: across the line of sight, along it [m], and of the rotation
# [rad] of one marker. Across and rotation grow with the pixel's size there, depth with its square.
_ACROSS = (0.0004, 0.0004)  # + per metre
_ALONG = (0.0008, 0.0015)  # + per square metre
_ROTATION = (0.002, 0.003)  # + per metre
_OUTLIER_WAY, _OUTLIER_TURN = (0.03, 0.5), (2.0, 15.0)  # [m], [deg]: ranges, drawn evenly in the logarithm
_FLIP_ALONE = 0.3  # share of flips that come instead of the right pose, not beside it
_RIGHT_WEIGHT = (0.35, 0.95)  # range of the right pose's weight beside a flip
# Logarithm of the right pose's odds over its flip where every image is ambiguous: mean and deviation of what is the
# same in all images of a run (light, print), deviation of what differs, and what the perspective tells at the steepest
# view from one metre.
_ODDS_OF_RUN, _ODDS_OF_IMAGE, _ODDS_OF_VIEW = (0.3, 0.8), 0.7, 8.0


class DockCamera:
    """Poses of the dock in the optical frame, for base_link at a pose in the dock's frame."""

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        pictures: Pictures,
        rng: np.random.Generator,
        installation: Installation | None = None,
    ) -> None:
        """`installation`: what is otherwise than `chair` and `dock` say."""
        self._pictures, self._rng, self._installation = pictures, rng, installation
        self._odds = rng.normal(*_ODDS_OF_RUN)
        mount = chair.camera if installation is None else installation.mount(chair.camera)
        self._mount = (mount.x, mount.y, mount.yaw)
        self._T_optical_base = np.linalg.inv(mount.T_base_optical())
        self._markers = dock.markers
        self._walls = [(*wall.min(axis=0), *wall.max(axis=0)) for wall in dock.bay.side_walls()]

    def seen(self, pose: Pose) -> list[Marker]:
        """The markers in the image: in the field of view, facing the camera, near enough, behind no side wall."""
        eye = compose(pose, self._mount)
        return [marker for marker in self._markers if self._sees(eye, marker)]

    def look(self, pose: Pose) -> list[Hypothesis]:
        """What perception says, likelier pose first in no particular order; empty when no marker is seen."""
        chances = self._rng.uniform(size=2)
        markers = self.seen(pose)
        if not markers:
            return []
        T_base_dock = inverse(pose)
        centre = np.mean([marker.position for marker in markers], axis=0)
        sds = self._sds(pose, markers, centre)
        if chances[0] < self._pictures.outliers:
            return [self._hypothesis(self._far_off(T_base_dock), markers, sds)]
        right = self._hypothesis(T_base_dock, markers, sds)
        if chances[1] >= self._pictures.flips and not self._pictures.ambiguous:
            return [right]
        mirrored = self._mirrored(T_base_dock, centre, markers[0])
        flipped = self._hypothesis(mirrored, markers, sds)
        if not self._pictures.ambiguous and self._rng.uniform() < _FLIP_ALONE:
            return [flipped]
        weight = self._right_weight(math.dist(compose(pose, self._mount)[:2], centre[:2]), mirrored[2] - T_base_dock[2])
        return [
            Hypothesis(right.T_optical_dock, right.covariance, weight),
            Hypothesis(flipped.T_optical_dock, flipped.covariance, 1.0 - weight),
        ]

    def sights(self, pose: Pose, rng: np.random.Generator) -> list[MarkerSight]:
        """Single markers of the same image; only their centres are drawn, each with the error of a marker alone. `rng`:
        of these, so that the poses of `look` do not depend on them."""
        sights = []
        T_optical_dock = self._T_optical_base @ pose_matrix(inverse(pose))
        for marker in self.seen(pose):
            there = np.asarray(marker.position) if self._installation is None else self._installation.place(marker)
            p = T_optical_dock[:3, :3] @ there + T_optical_dock[:3, 3]
            sds = self._sds(pose, [marker], np.asarray(marker.position))[:3]
            p = p + self._pictures.noise * sds * rng.normal(size=3)
            T = T_optical_dock @ marker.T_dock_marker()
            T[:3, 3] = p if self._installation is None else self._installation.centre(p)
            sights.append(MarkerSight(marker.id, T))
        return sights

    def _right_weight(self, distance: float, turn: float) -> float:
        """Of the right pose beside one that is turned by `turn` [rad], at this distance [m]."""
        if not self._pictures.ambiguous:
            return float(self._rng.uniform(*_RIGHT_WEIGHT))
        odds = self._odds + self._rng.normal(0.0, _ODDS_OF_IMAGE) + _ODDS_OF_VIEW * abs(math.sin(0.5 * turn)) / distance
        return min(0.99, max(0.01, 1.0 / (1.0 + math.exp(-odds))))

    def _sees(self, eye: Array, marker: Marker) -> bool:
        x, y = marker.position[:2]
        along = np.array([-math.sin(marker.normal_yaw), math.cos(marker.normal_yaw)]) * 0.5 * marker.size
        to_eye = math.atan2(eye[1] - y, eye[0] - x)
        distance = math.hypot(eye[0] - x, eye[1] - y)
        if not _NEAREST <= distance <= _SIDES * marker.size:
            return False
        if abs(math.remainder(to_eye - marker.normal_yaw, 2.0 * math.pi)) > _STEEPEST:
            return False
        for edge in ((x + along[0], y + along[1]), (x - along[0], y - along[1])):
            direction = math.atan2(edge[1] - eye[1], edge[0] - eye[0])
            if abs(math.remainder(direction - eye[2], 2.0 * math.pi)) > 0.5 * self._pictures.view:
                return False
            if any(crosses(float(eye[0]), float(eye[1]), *edge, wall) for wall in self._walls):
                return False
        return True

    def _sds(self, pose: Pose, markers: list[Marker], centre: Array) -> Array:
        """(6,): x, y, z of the markers' centre [m] and rotations [rad], along and about the optical axes."""
        eye = compose(pose, self._mount)
        d, n = math.hypot(eye[0] - centre[0], eye[1] - centre[1]), len(markers)
        across, depth = _ACROSS[0] + _ACROSS[1] * d, _ALONG[0] + _ALONG[1] * d * d
        turn = (_ROTATION[0] + _ROTATION[1] * d) / math.sqrt(n)
        base = max(math.dist(a.position, b.position) for a in markers for b in markers)
        if base > 0.0:  # two markers side by side: the difference of their depths
            turn = min(turn, math.sqrt(2.0) * depth / base)
        return np.array([across, across, depth, turn, turn, turn]) / np.sqrt([n, n, n, 1.0, 1.0, 1.0])

    def _hypothesis(self, T_base_dock: Array, markers: list[Marker], sds: Array) -> Hypothesis:
        """With an error of these standard deviations: the markers' centre shifts, and everything turns about it."""
        centre = np.mean([marker.position for marker in markers], axis=0)
        T = self._T_optical_base @ pose_matrix(T_base_dock)
        if self._installation is not None:
            T = self._installation.pose(T, markers)
        arm = T[:3, :3] @ -centre  # from the markers' centre to the dock's origin
        error = self._pictures.noise * sds * self._rng.normal(size=6)
        moved = np.eye(4)
        moved[:3, :3] = _rotation(error[3:])
        new = moved @ T
        new[:3, 3] = T[:3, 3] - arm + error[:3] + moved[:3, :3] @ arm
        J = np.eye(6)
        J[:3, 3:] = -_cross(arm)
        return Hypothesis(new, J @ np.diag(sds**2) @ J.T)

    def _far_off(self, T_base_dock: Array) -> Array:
        way, turn = (math.exp(self._rng.uniform(*np.log(ends))) for ends in (_OUTLIER_WAY, _OUTLIER_TURN))
        direction, side = self._rng.uniform(-math.pi, math.pi), self._rng.choice([-1.0, 1.0])
        shift = np.array([way * math.cos(direction), way * math.sin(direction), side * math.radians(turn)])
        return T_base_dock + shift

    def _mirrored(self, T_base_dock: Array, centre: Array, marker: Marker) -> Array:
        """The markers' centre stays; their normal is mirrored about the line of sight to it, seen from above."""
        x, y = transform_points(T_base_dock, centre[None, :2])[0]
        sight = math.atan2(y - self._mount[1], x - self._mount[0])
        heading = 2.0 * sight - T_base_dock[2] - 2.0 * marker.normal_yaw
        shift = transform_points((0.0, 0.0, heading), centre[None, :2])[0]
        return np.array([x - shift[0], y - shift[1], heading])


def crosses(x1: float, y1: float, x2: float, y2: float, box: tuple[float, float, float, float]) -> bool:
    """Whether the way from (x1, y1) to (x2, y2) meets the upright box (x low, y low, x high, y high): Liang-Barsky."""
    enter, leave = 0.0, 1.0
    for start, step, low, high in ((x1, x2 - x1, box[0], box[2]), (y1, y2 - y1, box[1], box[3])):
        if step == 0.0:
            if not low < start < high:
                return False
            continue
        first, last = sorted(((low - start) / step, (high - start) / step))
        enter, leave = max(enter, first), min(leave, last)
    return enter < leave


def _cross(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _rotation(vector: Array) -> Array:
    """Rodrigues' formula."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    K = _cross(vector / angle)
    return np.asarray(np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K)
