"""Which way round to the dock: forward, backward, past obstacles. A search over the lattice, once per approach.

The optimal control problem looks a few seconds ahead and finds the best motion near its guess; it does not find out
that it has to back up first. So the quickest path from everywhere to the corridor in front of the bay is searched
(Dijkstra, scipy), with the whole footprint clear of walls and obstacles and the markers in the camera's view. The
controller drives along it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angles
from seater_common.sight import Sight
from seater_nmpc.parameters import PlannerParameters
from seater_nmpc.plan import no_way
from seater_nmpc.plan.free_space import FreeSpace, final_straight_x
from seater_nmpc.plan.lattice import FORWARD, MODES, STAND, Lattice, Motion
from seater_nmpc.plan.path import Path, path_of

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

_NEAR_FACTOR = 10.0  # of a second near the bay's corners, where the path is to give room


class Planner:
    """Plans in the dock's frame. What costs time is done in the first call of `path` after obstacles changed."""

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        parameters: PlannerParameters,
        margin: float,
        field: FieldOfView,
        *,
        room: float = 0.0,
    ) -> None:
        """`margin` [m] and `field` (where in the image the markers are to be kept): the controller's. `room` [m]: how
        much farther ahead of the bay than it must the path joins the dock's axis; it gets out of what is nearer."""
        self._chair, self._dock, self._parameters = chair, dock, parameters
        self._free = FreeSpace(chair, margin + parameters.extra_margin)
        self._lattice = Lattice(chair, parameters)
        self._poses = self._lattice.poses()
        self._walls = dock.bay.outlines()
        self._x_last = final_straight_x(chair, dock) - room
        self._motions = [(motion, *self._lattice.edges(motion)) for motion in self._lattice.motions]
        self._obstacles: list[Array] = []
        self._to_go: Array | None = None
        self._open = True
        in_sight = np.any(Sight(chair.camera, dock, field).seen(self._poses), axis=1)
        self._factor = np.where(in_sight, 1.0, parameters.blind_factor)
        if room > 0.0:
            self._factor[self._poses[:, 0] > self._x_last] *= _NEAR_FACTOR
        self.reason = ""  # why the last `path` found none; empty when it found one
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
        self.reason = self._why_not(start) if node is None else ""
        if node is None:
            return None
        nodes, duration = [node], float(self._to_go[node])
        while self._next[nodes[-1]] >= 0:
            nodes.append(int(self._next[nodes[-1]]))
        at = self._lattice.pose_index(np.array(nodes))
        modes = np.array(nodes) // self._lattice.size
        moved = np.concatenate([[True], at[1:] != at[:-1]])
        return path_of(start, self._poses[at[moved]], modes[moved], duration)

    @property
    def open(self) -> bool:
        """Whether there is any way into the bay."""
        self.prepare()
        return self._open

    def clear_of_obstacles(self, poses: Array) -> bool:
        """Whether the footprint at all poses (n, 3) keeps the planner's margin from the obstacles."""
        return bool(np.all(self._free.clear(poses, self._obstacles)))

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

    def _why_not(self, start: Array) -> str:
        """Why no way leads from `start` to the corridor."""
        if not self._open:
            return self.blocked_by
        assert self._to_go is not None
        near = np.hypot(*(self._poses[:, :2] - start[:2]).T) <= 1.5 * self._parameters.cell
        if not np.any(near):
            return no_way.outside(start, self._parameters)
        for polygons, what in ((self._walls, "a wall"), (self._obstacles, "an obstacle")):
            if not self._free.clear(start[None], polygons)[0]:
                return no_way.too_near(what, self._free.margin)
        standing = self._to_go[STAND * self._lattice.size : (STAND + 1) * self._lattice.size]
        return no_way.NO_HEADING if np.any(np.isfinite(standing[near])) else no_way.enclosed(bool(self._obstacles))

    @property
    def blocked_by(self) -> str:
        """What leaves no way into the bay from anywhere; empty while it is open."""
        if self.open:
            return ""
        steps = np.arange(self._x_last, self._x_last - self._parameters.lane, -self._lattice.cell)
        straight = np.column_stack([steps, np.zeros((len(steps), 2))])
        if np.all(self._free.clear(straight, self._walls)):
            return no_way.OBSTACLES
        return no_way.narrow(self._chair, self._dock.bay, self._free.margin)

    def _search(self) -> None:
        """Cost to go of every node, and the next node on the way, by Dijkstra from the corridor on reversed edges."""
        areas = [*self._walls, *self._obstacles]
        size, free, factor = self._lattice.size, self._free.clear(self._poses, areas), self._factor
        rows, columns, costs = [], [], []
        for motion, start, end in self._clear_edges(free, areas):
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
        rows.append(np.full(len(goals), MODES * size))
        columns.append(FORWARD * size + goals)
        costs.append(1e-3 + self._time_from(self._poses[goals]))
        graph = coo_matrix(
            (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(MODES * size + 1,) * 2
        ).tocsr()
        self._to_go, before = dijkstra(graph, indices=MODES * size, return_predecessors=True)
        self._next = np.where((before < 0) | (before == MODES * size), -1, before).astype(np.intp)

    def _clear_edges(self, free: NDArray[np.bool_], areas: list[Array]) -> Iterator[tuple[Motion, Indices, Indices]]:
        """Each motion with the poses in which it may begin and end."""
        known: dict[tuple[int, int, tuple[int, int]], NDArray[np.bool_]] = {}  # whichever way it is driven
        for motion, start, end in self._motions:
            (dx, dy), there = motion.shift, (motion.heading, motion.heading_after, motion.shift)
            clear = known.get(there)
            if clear is None:
                clear = free[start] & free[end]
                begin = self._poses[start[clear], :2]
                clear[clear] = self._free.clear(np.column_stack([begin, np.zeros(len(begin))]) + motion.middle, areas)
                known[there] = known[motion.heading_after, motion.heading, (-dx, -dy)] = clear
            yield motion, start[clear], end[clear]

    def _goals(self, free: NDArray[np.bool_]) -> Indices:
        """Poses on the dock's axis from which the way into the bay is straight and clear."""
        x, y, heading = self._poses.T
        straight = free & (np.abs(y) < 1e-9) & (np.abs(heading) < 1e-9)
        last = self._x_last
        candidates = np.flatnonzero(straight & (x <= last + 1e-9) & (x >= last - self._parameters.lane))
        return np.array([i for i in candidates if self._lane_clear(float(x[i]))], dtype=np.intp)

    def _lane_clear(self, x: float) -> bool:
        """Walls count ahead of the bay; obstacles all the way to the dock."""
        steps = np.append(np.arange(x, 0.0, self._parameters.cell), 0.0)
        lane = np.column_stack([steps, np.zeros((len(steps), 2))])
        ahead = lane[steps <= self._x_last + 1e-9]
        return bool(np.all(self._free.clear(ahead, self._walls))) and self.clear_of_obstacles(lane)

    def _time_from(self, poses: Array) -> Array:
        """Seconds from goals, all ahead of the dock, straight to its frame (the bay's limit is the same for all)."""
        return -poses[:, 0] / self._chair.limits.v_max
