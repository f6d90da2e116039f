"""Prohibited areas, the bay's speed limit and the camera's field of view as soft constraints of a stage-wise programme."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.geometry import Chair
from seater_nmpc.geometry import Areas, Corner
from seater_nmpc.nlp import StageProgramme
from seater_nmpc.parameters import ControlParameters

Array = NDArray[np.float64]

_SOFTPLUS_WIDTH = 0.01  # [m] over which the bound on the speed bends from the bay's limit into the braking curve
_ROUNDING = 0.02  # [-] rounding of |sin| and |cos| in the reach of the footprint: slows down up to 10 mm early


class AreaConstraints:
    """Keeps the four corners of the footprint out of the areas and slows the chair down ahead of the bay.

    Per stage: one angle for each obstacle corner (the line that parts it from the chair) and three slacks, of the areas [m],
    of the bay's speed [m/s] and of the field of view [m], each at an exact price, so that nothing is ever infeasible.
    """

    def __init__(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme, areas: Areas) -> None:
        """`areas` fixes how many half-planes and corners there are; where they are comes with each instance."""
        self._chair, self._parameters = chair, parameters
        self._half_planes, self._corners = len(areas.half_planes), len(areas.corners)
        self._angles: list[slice] = []
        self._slacks: list[slice] = []
        self._p, self._where = programme.parameter("areas", _area_vector(areas).size)

    def add_stage(self, programme: StageProgramme, pose: ca.SX, v: ca.SX, step: float) -> None:
        """Constrain the footprint at the pose (3,) and the speed v there."""
        price, margin = self._parameters.weights.violation, self._parameters.margin
        angles, where = programme.variable("beta", [-math.inf] * self._corners, [math.inf] * self._corners)
        self._angles.append(where)
        slack, where = programme.variable("s", [0.0] * 3, [math.inf] * 3)
        self._slacks.append(where)
        footprint = _footprint(self._chair, pose)
        end = 3 * self._half_planes + 2 * self._corners
        planes = ca.reshape(self._p[: 3 * self._half_planes], 3, self._half_planes)
        points = ca.reshape(self._p[3 * self._half_planes : end], 2, self._corners)
        for i in range(self._half_planes):
            programme.constrain(planes[2, i] - margin - footprint @ planes[:2, i] + slack[0], 0.0, math.inf)
        for i in range(self._corners):
            normal = ca.vertcat(ca.cos(angles[i]), ca.sin(angles[i]))
            ahead = footprint @ normal - ca.dot(normal, points[:, i])
            programme.constrain(ahead - margin + slack[0], 0.0, math.inf)
        allowed = self._allowed_speed(pose, self._p[end : end + 3]) + slack[1]
        programme.constrain(ca.vertcat(allowed - v, allowed + v), 0.0, math.inf)
        programme.cost += step * price * (ca.sum1(slack[:2]) + ca.sumsqr(slack[:2]))
        programme.constrain(self._view(pose, self._p[end + 3 :]) + slack[2], 0.0, math.inf)
        programme.cost += step * self._parameters.weights.view * (slack[2] + slack[2] ** 2)

    def set_instance(self, areas: Areas, p: Array, lower: Array, upper: Array) -> None:
        """Write where the areas are into the parameters and the bounds."""
        p[self._where] = _area_vector(areas)
        for angles in self._angles:
            lower[angles] = [corner.first for corner in areas.corners]
            upper[angles] = [corner.last for corner in areas.corners]

    def guess(self, areas: Areas, states: Array, x: Array) -> None:
        """Write angles that part the areas from the poses of the stages 1..N, `states` (N + 1, >= 3), into x."""
        for k, angles in enumerate(self._angles):
            corners = self._chair.corners_at(states[k + 1, :3])
            x[angles] = [_separating_angle(corners, corner) for corner in areas.corners]

    def carry_over(self, old: Array, x: Array) -> None:
        """Copy angles and slacks of an earlier solution."""
        for where in [*self._angles, *self._slacks]:
            x[where] = old[where]

    def violation(self, x: Array) -> float:
        """Largest violation of an area or of the bay's speed in the plan [m or m/s]; the view is a wish, not counted."""
        return max(0.0, *(float(np.max(x[where][:2])) for where in self._slacks))

    def _view(self, pose: ca.SX, point: ca.SX) -> ca.SX:
        """How far, across the line of sight, the point is inside the left and right edge of the view, (2,) [m]."""
        mount, edge = self._chair.camera, math.tan(self._parameters.view_half_angle)
        c, s = ca.cos(pose[2]), ca.sin(pose[2])
        dx, dy = point[0] - pose[0], point[1] - pose[1]
        x, y = c * dx + s * dy - mount.x, c * dy - s * dx - mount.y
        cm, sm = math.cos(mount.yaw), math.sin(mount.yaw)
        x, y = cm * x + sm * y, cm * y - sm * x
        return ca.vertcat(edge * x - y, edge * x + y)

    def _allowed_speed(self, pose: ca.SX, entrance: ca.SX) -> ca.SX:
        """sqrt(v_bay^2 + 2 a (left)+): with `left` to go to the bay, the chair can still brake to the bay's limit."""
        limits = self._chair.limits
        braking = 2.0 * self._parameters.bay_deceleration * limits.a_max
        c, s = ca.cos(pose[2]), ca.sin(pose[2])
        forward = entrance[0] * c + entrance[1] * s  # cosine of the angle between the chair and the way into the bay
        sideways = entrance[1] * c - entrance[0] * s
        front = forward * 0.5 * (self._chair.length_front - self._chair.length_rear)
        length = 0.5 * (self._chair.length_front + self._chair.length_rear)
        reach = front + length * _rounded_abs(forward) + 0.5 * self._chair.width * _rounded_abs(sideways)
        left = entrance[2] - ca.dot(entrance[:2], pose[:2]) - reach
        smooth = 0.5 * (left + ca.sqrt(left**2 + _SOFTPLUS_WIDTH**2))
        at_entrance = (
            0.5 * _SOFTPLUS_WIDTH
        )  # value of the smooth maximum at 0: taken off, so that the limit holds there
        return ca.sqrt(limits.v_bay_max**2 + braking * (smooth - at_entrance))


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
    return np.concatenate([*planes, *[corner.point for corner in areas.corners], entrance, areas.view])


def _separating_angle(footprint: ArrayLike, corner: Corner) -> float:
    """Angle in [first, last] whose line has the footprint (4, 2) farthest ahead of it, from a coarse scan."""
    candidates = np.linspace(corner.first, corner.last, 9)
    normals = np.column_stack([np.cos(candidates), np.sin(candidates)])
    ahead = normals @ (np.asarray(footprint) - np.asarray(corner.point)).T
    return float(candidates[np.argmax(np.min(ahead, axis=1))])
