"""Which way round to the dock: forward, backward, past obstacles. A search over the lattice, once per approach.

The optimal control problem looks a few seconds ahead and finds the best motion near its guess; it does not find out
that it has to back up first. So the quickest path from everywhere to the corridor in front of the bay is searched
(Dijkstra, scipy), with the whole footprint clear of walls and obstacles and the markers in the camera's view. The
controller drives along it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angles
from seater_common.separation import edge_distances, footprints
from seater_nmpc.ocp.constraints.view import outermost_markers
from seater_nmpc.parameters import PlannerParameters
from seater_nmpc.plan.lattice import BACKWARD, FORWARD, STAND, Lattice

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Path:
    """A way to the corridor, in the dock's frame."""

    poses: Array  # (n, 3)
    backward: NDArray[np.bool_]  # (n,) whether the motion that ends in this pose is backward
    duration: float  # [s] that the search reckons with


class Planner:
    """Plans in the dock's frame. What costs time is done in the first call of `path` after obstacles changed."""

    def __init__(
        self, chair: Chair, dock: Dock, parameters: PlannerParameters, margin: float, view_half_angle: float
    ) -> None:
        """`margin` [m] and `view_half_angle` [rad]: the controller's."""
        self._chair, self._dock, self._parameters = chair, dock, parameters
        self._margin = margin + parameters.extra_margin
        self._half_angle = view_half_angle
        self._lattice = Lattice(chair, parameters)
        self._poses = self._lattice.poses()
        self._walls = dock.bay.outlines()
        view = outermost_markers(dock)
        self._view = (view.left, view.right)
        self._motions = [(motion, *self._lattice.edges(motion)) for motion in self._lattice.motions]
        self._obstacles: list[Array] = []
        self._to_go: Array | None = None
        self._open = True
        self._factor = np.where(self._sees(self._poses), 1.0, parameters.blind_factor)
        self._next: Indices = np.zeros(0, dtype=np.intp)

    @property
    def obstacles(self) -> list[Array]:
        """Those that the plans reckon with."""
        return self._obstacles

    def set_obstacles(self, polygons: list[Array]) -> None:
        """Convex anticlockwise polygons (n, 2) in the dock's frame [m]."""
        self._obstacles, self._to_go = list(polygons), None

    def prepare(self) -> None:
        """Search now, so that the first `path` does not have to."""
        if self._to_go is None:
            self._search()

    def path(self, start: ArrayLike) -> Path | None:
        """The quickest way from standing at `start` (x, y, heading) to the corridor; None when there is none."""
        self.prepare()
        assert self._to_go is not None
        start = np.asarray(start, dtype=float)
        node = self._attach(start)
        if node is None:
            return None
        nodes, duration = [node], float(self._to_go[node])
        while self._next[nodes[-1]] >= 0:
            nodes.append(int(self._next[nodes[-1]]))
        at = self._lattice.pose_index(np.array(nodes))
        modes = np.array(nodes) // self._lattice.size
        moved = np.concatenate([[True], at[1:] != at[:-1]])
        poses = np.vstack([start, self._poses[at[moved]]])
        return Path(poses, np.concatenate([[False], modes[moved] == BACKWARD]), duration)

    @property
    def open(self) -> bool:
        """Whether there is any way into the bay."""
        self.prepare()
        return self._open

    def clear_of_obstacles(self, poses: Array) -> bool:
        """Whether the footprint at all poses (n, 3) keeps the planner's margin from the obstacles."""
        return bool(np.all(self._clear(poses, self._obstacles)))

    def _clear(self, poses: Array, polygons: list[Array]) -> NDArray[np.bool_]:
        """(n,) whether the footprint at each pose keeps the margin from the polygons."""
        result = np.ones(len(poses), dtype=bool)
        reach = math.hypot(max(self._chair.length_front, self._chair.length_rear), 0.5 * self._chair.width)
        for polygon in polygons:
            low, high = polygon.min(axis=0) - reach - self._margin, polygon.max(axis=0) + reach + self._margin
            near = np.flatnonzero(np.all((poses[:, :2] > low) & (poses[:, :2] < high), axis=1))
            shapes = footprints(self._chair.corners(), poses[near])
            result[near] &= edge_distances(shapes, polygon) >= self._margin
        return result

    def _attach(self, start: Array) -> int | None:
        """The node near the start from which the rest is quickest, the way there reckoned in."""
        assert self._to_go is not None
        p, limits = self._parameters, self._chair.limits
        away = np.hypot(*(self._poses[:, :2] - start[:2]).T)
        turn = np.abs(wrap_angles(self._poses[:, 2] - start[2]))
        near = np.flatnonzero((away <= 1.5 * p.cell) & (turn <= 0.5))
        cost = 4.0 * away[near] / limits.v_max + 2.0 * turn[near] / limits.omega_max
        cost += self._to_go[STAND * self._lattice.size + near]
        if len(near) == 0 or not np.isfinite(np.min(cost)):
            return None
        return int(STAND * self._lattice.size + near[np.argmin(cost)])

    def _search(self) -> None:
        """Cost to go of every node, and the next node on the way, by Dijkstra from the corridor on reversed edges."""
        areas = [*self._walls, *self._obstacles]
        size, free, factor = self._lattice.size, self._clear(self._poses, areas), self._factor
        rows, columns, costs = [], [], []
        for motion, start, end in self._motions:
            open_ = free[start] & free[end]
            start, end = start[open_], end[open_]
            middles = np.column_stack([self._poses[start, :2], np.zeros(len(start))]) + motion.middle
            clear = self._clear(middles, areas)
            start, end = start[clear], end[clear]
            rows.append(motion.mode * size + end)
            columns.append(motion.mode * size + start)
            costs.append(motion.duration * 0.5 * (factor[start] + factor[end]))
        everywhere = np.flatnonzero(free)
        for mode, after, duration in self._lattice.mode_changes():
            rows.append(after * size + everywhere)
            columns.append(mode * size + everywhere)
            costs.append(np.full(len(everywhere), duration))
        goals = self._goals(free)
        self._open = len(goals) > 0
        rows.append(np.full(len(goals), 3 * size))
        columns.append(FORWARD * size + goals)
        costs.append(1e-3 + self._time_from(self._poses[goals]))
        graph = coo_matrix(
            (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(3 * size + 1,) * 2
        ).tocsr()
        self._to_go, before = dijkstra(graph, indices=3 * size, return_predecessors=True)
        self._next = np.where((before < 0) | (before == 3 * size), -1, before).astype(np.intp)

    def _goals(self, free: NDArray[np.bool_]) -> Indices:
        """Poses on the dock's axis from which the way into the bay is straight and clear."""
        x, y, heading = self._poses.T
        straight = free & (np.abs(y) < 1e-9) & (np.abs(heading) < 1e-9)
        x_last = self._dock.bay.entrance_x - self._chair.length_front
        candidates = np.flatnonzero(straight & (x <= x_last + 1e-9) & (x >= x_last - self._parameters.lane))
        return np.array([i for i in candidates if self._lane_clear(float(x[i]))], dtype=np.intp)

    def _lane_clear(self, x: float) -> bool:
        """Walls count ahead of the bay; obstacles all the way to the dock."""
        steps = np.append(np.arange(x, 0.0, self._parameters.cell), 0.0)
        lane = np.column_stack([steps, np.zeros((len(steps), 2))])
        ahead = lane[steps <= self._dock.bay.entrance_x - self._chair.length_front + 1e-9]
        return bool(np.all(self._clear(ahead, self._walls))) and self.clear_of_obstacles(lane)

    def _time_from(self, poses: Array) -> Array:
        """Seconds from a goal pose straight to the dock's frame (the bay's speed limit is the same for all)."""
        return -poses[:, 0] / self._chair.limits.v_max

    def _sees(self, poses: Array) -> NDArray[np.bool_]:
        """Whether a marker is in the camera's view, well inside, as the optimal control problem has it."""
        edge = math.tan(self._half_angle)
        (left, ahead_left), (right, ahead_right) = (self._sideways(poses, point) for point in self._view)
        return np.asarray((right <= edge * ahead_right) & (-left <= edge * ahead_left))

    def _sideways(self, poses: Array, point: tuple[float, float]) -> tuple[Array, Array]:
        """Where the point is seen from the camera at the poses (n, 3): to the left and ahead, (n,) each [m]."""
        mount = self._chair.camera
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        dx, dy = point[0] - poses[:, 0], point[1] - poses[:, 1]
        x, y = c * dx + s * dy - mount.x, c * dy - s * dx - mount.y
        cm, sm = math.cos(mount.yaw), math.sin(mount.yaw)
        return cm * y - sm * x, cm * x + sm * y
