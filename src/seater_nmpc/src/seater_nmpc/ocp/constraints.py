"""Prohibited areas, the bay's speed limit and the camera's field of view as soft constraints of a stage-wise programme."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair, Limits
from seater_nmpc.ocp.geometry import Areas, Corner
from seater_nmpc.ocp.nlp import StageProgramme
from seater_nmpc.ocp.separation import Lines, footprints, nearest, parting_lines
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

# The bound on the speed bends from the bay's limit into the braking curve over a few times this width [m], so far ahead of
# the entrance [m]. Sharper, and full steps across the bend do not settle.
_SOFTPLUS_WIDTH = 0.06
_SOFTPLUS_SHIFT = 3.0 * _SOFTPLUS_WIDTH
_NO_LINE = -1.0  # [m] offset, beside a normal of zero, of a line that constrains nothing
_LINE_SIZE = (
    7  # parameters of a line: normal, offset, and the two corners of the footprint (in base_link) nearest to it
)
_ROUNDING = 0.02  # [-] rounding of |sin| and |cos| in the reach of the footprint: slows down up to 10 mm early


@dataclass(frozen=True)
class _Stage:
    """What one stage's constraints are made of."""

    heading: ca.SX
    footprint: ca.SX  # (4, 2)
    angles: ca.SX
    rooms: list[ca.SX]  # how much room is left, without slack: areas, speed, view


def allowed_speed(left: ca.SX, limits: Limits, deceleration: float) -> ca.SX:
    """sqrt(v_bay^2 + 2 a (left)+), smooth: with `left` [m] to go to the bay, the chair can still brake to the bay's limit.

    a is the share `deceleration` of the chair's largest one. At the entrance it is the bay's limit exactly.
    """
    smooth = _softplus(left - _SOFTPLUS_SHIFT) - _softplus(ca.SX(-_SOFTPLUS_SHIFT))
    return ca.sqrt(limits.v_bay_max**2 + 2.0 * deceleration * limits.a_max * smooth)


class AreaConstraints:
    """Keeps the four corners of the footprint out of the areas and slows the chair down ahead of the bay.

    Per stage: one angle for each obstacle corner (the line that parts it from the chair) and three slacks, of the areas [m],
    of the bay's speed [m/s] and of the field of view [m], each at an exact price, so that nothing is ever infeasible.

    Polygons that come at run time are kept clear of by lines that are given with each instance, for every stage the nearest
    `max_obstacles` (see `obstacle_lines`): they cost no variables, and a plan that keeps them is clear of the polygons.
    """

    def __init__(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme, areas: Areas) -> None:
        """`areas` fixes how many half-planes and corners there are; where they are comes with each instance."""
        self._chair, self._parameters = chair, parameters
        self._half_planes, self._corners = len(areas.half_planes), len(areas.corners)
        self._angles: list[slice] = []
        self._slacks: list[slice] = []
        self._stages: list[_Stage] = []
        self._columns: tuple[NDArray[np.int_], NDArray[np.int_]] | None = None
        self._p, self._where = programme.parameter("areas", _area_vector(areas).size)
        self._slots = parameters.max_obstacles
        self._lines, self._lines_where = programme.parameter("lines", _LINE_SIZE * self._slots * parameters.horizon)

    def add_stage(self, programme: StageProgramme, pose: ca.SX, v: ca.SX, step: float) -> None:
        """Constrain the footprint at the pose (3,) and the speed v there."""
        price, margin = self._parameters.weights.violation, self._parameters.margin
        angles, where = programme.variable("beta", [-math.inf] * self._corners, [math.inf] * self._corners)
        self._angles.append(where)
        slack, where = programme.variable("s", [0.0] * 3, [math.inf] * 3)
        self._slacks.append(where)
        footprint = _footprint(self._chair, pose)
        planes, points, entrance, view = self._instance()
        lines = [ca.vertcat(ca.cos(angles[i]), ca.sin(angles[i])) for i in range(self._corners)]
        area = [planes[2, i] - margin - footprint @ planes[:2, i] for i in range(self._half_planes)]
        area += [footprint @ line - ca.dot(line, points[:, i]) - margin for i, line in enumerate(lines)]
        area += [room - margin for room in self._obstacle_rooms(pose)]
        allowed = self._allowed_speed(pose, entrance)
        speed, sight = ca.vertcat(allowed - v, allowed + v), self._view(pose, view)
        for i, rooms in enumerate((area, [speed], [sight])):
            for room in rooms:
                programme.constrain(room + slack[i], 0.0, math.inf)
        programme.cost += step * price * (ca.sum1(slack[:2]) + ca.sumsqr(slack[:2]))
        programme.cost += step * self._parameters.weights.view * (slack[2] + slack[2] ** 2)
        self._stages.append(_Stage(pose[2], footprint, angles, [ca.vertcat(*area), speed, sight]))

    def _obstacle_rooms(self, pose: ca.SX) -> list[ca.SX]:
        """How far the footprint's two nearest corners are ahead of each line of the stage that is being added [m]."""
        c, s = ca.cos(pose[2]), ca.sin(pose[2])
        rooms, size, stage = [], _LINE_SIZE, len(self._stages)
        for slot in range(self._slots):
            at = size * (stage * self._slots + slot)
            line = self._lines[at : at + size]
            for corner in (line[3:5], line[5:7]):
                x, y = pose[0] + c * corner[0] - s * corner[1], pose[1] + s * corner[0] + c * corner[1]
                rooms.append(line[0] * x + line[1] * y - line[2])
        return rooms

    def refinement(self, x: ca.SX, lower: ca.SX, upper: ca.SX) -> ca.SX:
        """The variables x with, for the poses in them, the best parting lines and the smallest sufficient slacks.

        What a linearisation says about lines and slacks holds near its point only; this says the truth about an iterate.
        """
        x, points = ca.SX(x), self._instance()[1]
        for k, stage in enumerate(self._stages):
            where, best = self._angles[k], []
            for i in range(self._corners):
                j = where.start + i
                best.append(
                    _best_angle(stage.footprint - ca.repmat(points[:, i].T, 4, 1), stage.heading, lower[j], upper[j])
                )
            x[where] = ca.vertcat(*best)
            rooms = ca.substitute(stage.rooms, [stage.angles], [x[where]]) if best else stage.rooms
            x[self._slacks[k]] = ca.vertcat(*[ca.fmax(0.0, -ca.mmin(room)) for room in rooms])
        return x

    def _instance(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
        """Half-planes (3, n), corners (2, m), entrance (3,) and view (4,) out of the parameters."""
        end = 3 * self._half_planes + 2 * self._corners
        planes = ca.reshape(self._p[: 3 * self._half_planes], 3, self._half_planes)
        points = ca.reshape(self._p[3 * self._half_planes : end], 2, self._corners)
        return planes, points, self._p[end : end + 3], self._p[end + 3 :]

    def set_instance(self, areas: Areas, p: Array, lower: Array, upper: Array, lines: Array | None = None) -> None:
        """Write where the areas and the `obstacle_lines` are into the parameters and the bounds."""
        p[self._where] = _area_vector(areas)
        p[self._lines_where] = np.ravel(self._no_lines() if lines is None else lines)
        columns, _ = self._index()
        lower[columns] = [corner.first for corner in areas.corners]
        upper[columns] = [corner.last for corner in areas.corners]

    def _no_lines(self) -> Array:
        """Lines that constrain nothing, (N, slots, 7)."""
        lines = np.zeros((self._parameters.horizon, self._slots, _LINE_SIZE))
        lines[:, :, 2] = _NO_LINE
        return lines

    def obstacle_lines(self, polygons: list[Array], states: Array) -> Array:
        """Parameters of the lines that part the footprint, at the states of the stages 1..N, from the nearest polygons.

        `polygons`: convex, anticlockwise, (n, 2) each, in the frame of `states` (N + 1, >= 3). Shape (N, slots, 7).
        """
        result, corners = self._no_lines(), self._chair.corners()
        if not polygons or self._slots == 0:
            return result
        shapes = footprints(corners, states[1:])
        lines: Lines = nearest(parting_lines(shapes, polygons), self._slots)
        count = lines.offsets.shape[1]
        ahead = lines.normals @ shapes.transpose(0, 2, 1)  # (N, count, 4)
        two = np.argsort(ahead, axis=2, kind="stable")[:, :, :2]
        result[:, :count, :2], result[:, :count, 2] = lines.normals, lines.offsets
        result[:, :count, 3:] = corners[two].reshape(len(shapes), count, 4)
        return result

    def guess(self, areas: Areas, states: Array, x: Array) -> None:
        """Write angles that part the areas from the poses of the stages 1..N, `states` (N + 1, >= 3), into x."""
        for k, angles in enumerate(self._angles):
            corners = self._chair.corners_at(states[k + 1, :3])
            x[angles] = [_separating_angle(corners, corner) for corner in areas.corners]

    def carry_over(self, old: Array, x: Array) -> None:
        """Copy angles and slacks of an earlier solution."""
        for columns in self._index():
            x[columns] = old[columns]

    def violation(self, x: Array) -> float:
        """Largest violation of an area or of the bay's speed in the plan [m or m/s]; the view is a wish, not counted."""
        return max(0.0, float(np.max(x[self._index()[1][:, :2]])))

    def _index(self) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Where angles (N, corners) and slacks (N, 3) stand in x."""
        if self._columns is None:
            both = [[np.arange(where.start, where.stop) for where in part] for part in (self._angles, self._slacks)]
            self._columns = np.array(both[0]), np.array(both[1])
        return self._columns

    def _view(self, pose: ca.SX, points: ca.SX) -> ca.SX:
        """How far, across the line of sight, the right point is inside the left edge of the view, and the left point inside
        the right edge, (2,) [m]: then one of them is in view, as far as they fit into it."""
        edge = math.tan(self._parameters.view_half_angle)
        (x_left, y_left), (x_right, y_right) = (self._in_camera(pose, points[i : i + 2]) for i in (0, 2))
        return ca.vertcat(edge * x_right - y_right, edge * x_left + y_left)

    def _in_camera(self, pose: ca.SX, point: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The point ahead of the camera and to its left [m]."""
        mount, c, s = self._chair.camera, ca.cos(pose[2]), ca.sin(pose[2])
        dx, dy = point[0] - pose[0], point[1] - pose[1]
        x, y = c * dx + s * dy - mount.x, c * dy - s * dx - mount.y
        cm, sm = math.cos(mount.yaw), math.sin(mount.yaw)
        return cm * x + sm * y, cm * y - sm * x

    def _allowed_speed(self, pose: ca.SX, entrance: ca.SX) -> ca.SX:
        """The largest speed [m/s] for a pose: see `allowed_speed`."""
        c, s = ca.cos(pose[2]), ca.sin(pose[2])
        forward = entrance[0] * c + entrance[1] * s  # cosine of the angle between the chair and the way into the bay
        sideways = entrance[1] * c - entrance[0] * s
        front = forward * 0.5 * (self._chair.length_front - self._chair.length_rear)
        length = 0.5 * (self._chair.length_front + self._chair.length_rear)
        reach = front + length * _rounded_abs(forward) + 0.5 * self._chair.width * _rounded_abs(sideways)
        left = entrance[2] - ca.dot(entrance[:2], pose[:2]) - reach
        return allowed_speed(left, self._chair.limits, self._parameters.bay_deceleration)


def _softplus(value: ca.SX) -> ca.SX:
    """A smooth max(0, value): w log(1 + exp(value / w)), in a form that does not overflow."""
    return ca.fmax(value, 0.0) + _SOFTPLUS_WIDTH * ca.log1p(ca.exp(-ca.fabs(value) / _SOFTPLUS_WIDTH))


def _rounded_abs(value: ca.SX) -> ca.SX:
    return ca.sqrt(value**2 + _ROUNDING**2)


def _footprint(chair: Chair, pose: ca.SX) -> ca.SX:
    """Corners of the footprint, (4, 2), of the chair at the pose."""
    c, s = ca.cos(pose[2]), ca.sin(pose[2])
    rotation = ca.vertcat(ca.horzcat(c, s), ca.horzcat(-s, c))
    return ca.DM(chair.corners()) @ rotation + ca.repmat(pose[:2].T, 4, 1)


def _area_vector(areas: Areas) -> Array:
    """Parameters: (normal, offset) of each half-plane, (x, y) of each corner, (normal, offset) of the entrance, view."""
    planes = [[math.cos(plane.angle), math.sin(plane.angle), plane.offset] for plane in areas.half_planes]
    entrance = [math.cos(areas.entrance.angle), math.sin(areas.entrance.angle), areas.entrance.offset]
    return np.concatenate([*planes, *[corner.point for corner in areas.corners], entrance, *areas.view])


def _separating_angle(footprint: ArrayLike, corner: Corner) -> float:
    """Angle in [first, last] whose line has the footprint (4, 2) farthest ahead of it, from a coarse scan."""
    candidates = np.linspace(corner.first, corner.last, 9)
    normals = np.column_stack([np.cos(candidates), np.sin(candidates)])
    ahead = normals @ (np.asarray(footprint) - np.asarray(corner.point)).T
    return float(candidates[np.argmax(np.min(ahead, axis=1))])


def _best_angle(corners: ca.SX, heading: ca.SX, first: ca.SX, last: ca.SX) -> ca.SX:
    """The angle b in [first, last] with the largest min_i (cos b, sin b) . V_i, for the corners V (4, 2) seen from the point.

    It is one of: the ends of the range, the direction of a corner, the direction across a side of the footprint.
    """
    begin, end = (ca.vertcat(ca.cos(angle), ca.sin(angle)) for angle in (first, last))
    across = ca.vertcat(ca.cos(heading), ca.sin(heading))
    along = ca.vertcat(-across[1], across[0])
    directions = [corners[i, :].T / ca.sqrt(ca.sumsqr(corners[i, :]) + 1e-12) for i in range(4)]
    best, room = begin, ca.mmin(corners @ begin)
    for line in [end, *directions, across, -across, along, -along]:
        inside = ca.fmin(_cross(begin, line), _cross(line, end)) >= 0.0
        ahead = ca.if_else(inside, ca.mmin(corners @ line), -math.inf)
        best = ca.if_else(ahead > room, line, best)
        room = ca.fmax(ahead, room)
    return ca.fmin(first + ca.acos(ca.fmax(-1.0, ca.fmin(1.0, ca.dot(begin, best)))), last)


def _cross(a: ca.SX, b: ca.SX) -> ca.SX:
    return a[0] * b[1] - a[1] * b[0]
