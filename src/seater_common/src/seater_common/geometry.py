"""The chair and the dock: what simulation, control and evaluation must agree on (config/chair.yaml, config/docks/)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.params import param
from seater_common.se2 import transform_points, wrap_angle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CameraMount:
    """Where the camera sits: its body frame camera_link in base_link."""

    x: float = param(0.45, "m", "ahead of the driven axle", low=-2.0, high=2.0)
    y: float = param(0.0, "m", "left of the middle", low=-1.0, high=1.0)
    z: float = param(0.70, "m", "above the floor", low=0.0, high=2.0)
    roll: float = param(0.0, "rad", "about x", low=-math.pi, high=math.pi)
    pitch: float = param(0.0, "rad", "about y; positive looks down", low=-1.6, high=1.6)
    yaw: float = param(0.0, "rad", "about z; positive looks left", low=-math.pi, high=math.pi)

    def T_base_optical(self) -> Array:
        """4x4 pose of the optical frame (z forward, x right, y down) in base_link."""
        T = np.eye(4)
        body_to_optical = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
        T[:3, :3] = rotation_rpy(self.roll, self.pitch, self.yaw) @ body_to_optical
        T[:3, 3] = [self.x, self.y, self.z]
        return T


@dataclass(frozen=True)
class Limits:
    """What the chair may be asked for."""

    v_max: float = param(0.6, "m/s", "largest forward speed", low=0.01, high=3.0)
    v_reverse_max: float = param(0.3, "m/s", "largest backward speed", low=0.0, high=3.0)
    omega_max: float = param(0.8, "rad/s", "largest turning rate, both ways", low=0.01, high=4.0)
    a_max: float = param(0.5, "m/s^2", "largest change of speed, both ways", low=0.01, high=5.0)
    alpha_max: float = param(1.0, "rad/s^2", "largest change of turning rate, both ways", low=0.01, high=10.0)
    v_bay_max: float = param(0.15, "m/s", "largest speed while the footprint reaches into the bay", low=0.01, high=1.0)


@dataclass(frozen=True)
class Chair:
    """The vehicle: a unicycle round base_link (middle of the driven axle, x forward) with a rectangular footprint."""

    length_front: float = param(0.75, "m", "footprint ahead of the axle", low=0.0, high=3.0)
    length_rear: float = param(0.30, "m", "footprint behind the axle", low=0.0, high=3.0)
    width: float = param(0.65, "m", "footprint across", low=0.1, high=3.0)
    limits: Limits = field(default_factory=Limits)
    camera: CameraMount = field(default_factory=CameraMount)

    def corners(self) -> Array:
        """Footprint corners in base_link, (4, 2) [m], anticlockwise from front left."""
        half = 0.5 * self.width
        return np.array(
            [
                [self.length_front, half],
                [-self.length_rear, half],
                [-self.length_rear, -half],
                [self.length_front, -half],
            ]
        )

    def corners_at(self, pose: ArrayLike) -> Array:
        """Footprint corners, (4, 2) [m], in the frame in which the pose (x, y, heading) of base_link is given."""
        return transform_points(pose, self.corners())


@dataclass(frozen=True)
class Marker:
    """One printed marker standing upright at the dock."""

    id: int = param(0, "", "number in the dictionary", low=0)
    size: float = param(0.1, "m", "side of the black square", low=0.005, high=2.0)
    position: list[float] = param([0.9, 0.0, 0.7], "m", "centre in the dock frame", length=3)
    normal_yaw: float = param(
        math.pi, "rad", "direction in which the print faces, about z of the dock frame", low=-3.1416, high=3.1416
    )

    def T_dock_marker(self) -> Array:
        """4x4 pose of the marker frame (x right, y up as the print is read, z out of the paper) in the dock frame."""
        normal = np.array([math.cos(self.normal_yaw), math.sin(self.normal_yaw), 0.0])
        up = np.array([0.0, 0.0, 1.0])
        T = np.eye(4)
        T[:3, :3] = np.column_stack([np.cross(up, normal), up, normal])
        T[:3, 3] = self.position
        return T

    def corners(self) -> Array:
        """Corners in the marker frame, (4, 3) [m]: top-left, top-right, bottom-right, bottom-left as read."""
        h = 0.5 * self.size
        return np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])


@dataclass(frozen=True)
class Bay:
    """A back wall across x and two side walls along x, in the dock frame."""

    width: float = param(1.0, "m", "between the side walls", low=0.1, high=10.0)
    back_wall_x: float = param(0.9, "m", "back wall ahead of the docked axle", low=0.0, high=10.0)
    side_wall_length: float = param(
        0.9, "m", "how far the side walls run out from the back wall; 0: there are none", low=0.0, high=10.0
    )
    wall_thickness: float = param(0.10, "m", "of the side walls", low=0.01, high=1.0)
    wall_height: float = param(1.2, "m", "of all walls", low=0.1, high=4.0)

    @property
    def entrance_x(self) -> float:
        """Where the side walls begin, in the dock frame [m]."""
        return self.back_wall_x - self.side_wall_length

    def side_walls(self) -> list[Array]:
        """Left and right wall as convex polygons, (4, 2) [m] each, anticlockwise, in the dock frame; none of an open
        dock (side_wall_length 0)."""
        if self.side_wall_length <= 0.0:
            return []
        inner, outer = 0.5 * self.width, 0.5 * self.width + self.wall_thickness
        near, far = self.entrance_x, self.back_wall_x
        left = np.array([[near, inner], [far, inner], [far, outer], [near, outer]])
        right = np.array([[near, -outer], [far, -outer], [far, -inner], [near, -inner]])
        return [left, right]

    def outlines(self) -> list[Array]:
        """Side walls and the back wall, as `side_walls`."""
        half, x = 0.5 * self.width + self.wall_thickness, self.back_wall_x
        back = np.array([[x, -half], [x + self.wall_thickness, -half], [x + self.wall_thickness, half], [x, half]])
        return [*self.side_walls(), back]


@dataclass(frozen=True)
class Tolerance:
    """What counts as docked: base_link in the dock frame."""

    position: float = param(0.010, "m", "largest distance", low=0.0005, high=0.5)
    heading: float = param(0.01745, "rad", "largest heading error", low=0.0001, high=1.0)


@dataclass(frozen=True)
class Dock:
    """A dock: the frame `dock` is where base_link's origin must be when docked, x pointing into the bay.

    The docked chair faces along x, or, at a dock that is entered backward, against it.
    """

    name: str = param("default", "", "how a goal names it")
    direction: str = param("forward", "", "end of the chair that goes in first", choices=("forward", "backward"))
    dictionary: str = param("DICT_4X4_50", "", "name of the marker family")
    markers: list[Marker] = field(
        default_factory=lambda: [
            Marker(0, 0.100, [0.9, 0.0, 0.7]),
            Marker(1, 0.150, [0.9, 0.35, 0.7]),
            Marker(2, 0.150, [0.9, -0.35, 0.7]),
        ]
    )
    bay: Bay = field(default_factory=Bay)
    predock_x: float = param(
        -1.2, "m", "predock point on the dock's x axis, where the final straight begins", low=-5.0, high=-0.05
    )
    tolerance: Tolerance = field(default_factory=Tolerance)
    contact_tolerance: Tolerance = field(default_factory=lambda: Tolerance(0.020, 0.035))

    def __post_init__(self) -> None:
        ids = [marker.id for marker in self.markers]
        if not ids:
            raise ValueError("markers: is empty, must name at least one marker")
        if len(set(ids)) != len(ids):
            raise ValueError(f"markers: ids {ids} are not all different")

    @property
    def docked_pose(self) -> Array:
        """Pose (x, y, heading) of the docked chair's base_link in the dock frame [m, m, rad]."""
        return np.array([0.0, 0.0, math.pi if self.direction == "backward" else 0.0])

    @property
    def front(self) -> Array:
        """Middle of the markers and the mean direction in which they face, (x, y, yaw) in the dock frame [m, rad]."""
        x, y = np.mean([marker.position[:2] for marker in self.markers], axis=0)
        yaws = [marker.normal_yaw for marker in self.markers]
        return np.array([x, y, math.atan2(sum(map(math.sin, yaws)), sum(map(math.cos, yaws)))])

    def docking_error(self, T_dock_base: ArrayLike) -> Array:
        """(x, y, heading) [m, m, rad] of base_link, along the dock's axes, less the docked pose: zero when docked."""
        x, y, heading = np.asarray(T_dock_base, dtype=float) - self.docked_pose
        return np.array([x, y, wrap_angle(heading)])


def rotation_rpy(roll: float, pitch: float, yaw: float) -> Array:
    """3x3 rotation, fixed axes x, y, z in this order (as in URDF and tf)."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_matrix(x: float, y: float, z: float, w: float) -> Array:
    """3x3 rotation of a unit quaternion."""
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(R: ArrayLike) -> tuple[float, float, float, float]:
    """(x, y, z, w >= 0) of a 3x3 rotation: the eigenvector of the largest eigenvalue of Bar-Itzhack's matrix
    (J. Guidance 23(6), 2000)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = np.asarray(R, dtype=float)
    K = np.array(
        [
            [xx - yy - zz, yx + xy, zx + xz, zy - yz],
            [yx + xy, yy - xx - zz, zy + yz, xz - zx],
            [zx + xz, zy + yz, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    vector = np.linalg.eigh(K)[1][:, -1]
    x, y, z, w = (math.copysign(1.0, vector[3]) * vector).tolist()
    return x, y, z, w


def pose_matrix(pose: ArrayLike) -> Array:
    """4x4 transform of a planar pose (x, y, heading)."""
    x, y, heading = np.asarray(pose, dtype=float)
    T = np.eye(4)
    T[:3, :3] = rotation_rpy(0.0, 0.0, heading)
    T[:3, 3] = [x, y, 0.0]
    return T


def planar_pose(T: ArrayLike) -> Array:
    """(x, y, heading) of a 4x4 transform: its translation and the direction of its x axis, seen from above."""
    T = np.asarray(T, dtype=float)
    return np.array([T[0, 3], T[1, 3], math.atan2(T[1, 0], T[0, 0])])


def polygon_distance(a: ArrayLike, b: ArrayLike) -> float:
    """Signed distance of two convex polygons, (n, 2) and (m, 2), anticlockwise [m]; negative when they overlap.

    The distance is exact; of an overlap it is the smallest separating shift along an edge normal (separating axes).
    """
    return float(polygon_distances(a, np.asarray(b, dtype=float)[None])[0])


def polygon_distances(a: ArrayLike, others: ArrayLike) -> Array:
    """polygon_distance of a (n, 2) from each of the others (k, m, 2), (k,) [m]."""
    a, others = np.asarray(a, dtype=float)[None], np.asarray(others, dtype=float)
    distances = np.maximum(_axis_separations(a, others), _axis_separations(others, a))
    apart = distances > 0.0
    if apart.any():
        free = others[apart]
        distances[apart] = np.minimum(_vertex_distances(a, free), _vertex_distances(free, a))
    return distances


def _axis_separations(a: Array, b: Array) -> Array:
    """Largest distances of each b behind an edge of a, over the edges of a [m]; shapes (k, n, 2) and (k, m, 2), where
    one k may be 1."""
    edges = _following(a) - a
    lengths = np.sqrt((edges * edges).sum(axis=2))[:, :, None]
    normals = np.stack([edges[:, :, 1], -edges[:, :, 0]], axis=2) / lengths
    distances = normals @ b.transpose(0, 2, 1) - (normals * a).sum(axis=2)[:, :, None]
    return np.asarray(distances.min(axis=2).max(axis=1))


def _vertex_distances(points: Array, polygons: Array) -> Array:
    """Smallest distances of the points (k, n, 2) from the polygons' edges (k, m, 2) [m], where one k may be 1."""
    start = polygons[:, None, :, :]
    edge = _following(polygons)[:, None, :, :] - start
    to_point = points[:, :, None, :] - start
    along = (to_point * edge).sum(axis=3) / (edge * edge).sum(axis=3)
    off = to_point - np.minimum(np.maximum(along, 0.0), 1.0)[:, :, :, None] * edge
    return np.asarray(np.sqrt((off * off).sum(axis=3).min(axis=(1, 2))))


def _following(polygons: Array) -> Array:
    """For each corner the next one; shape (k, n, 2)."""
    return np.concatenate([polygons[:, 1:], polygons[:, :1]], axis=1)


def clearance(chair: Chair, bay: Bay, T_dock_base: ArrayLike) -> float:
    """Smallest distance between the chair's footprint and the bay's walls [m]; negative when they overlap."""
    return float(polygon_distances(chair.corners_at(T_dock_base), bay.outlines()).min())
