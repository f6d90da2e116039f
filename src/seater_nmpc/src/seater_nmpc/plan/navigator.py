"""Where to drive to until the chair is in front of the bay: plans, follows the plan, plans anew when it has to."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.se2 import wrap_angle
from seater_nmpc.ocp.constraints.view import kept_field
from seater_nmpc.parameters import ControlParameters, PlannerParameters
from seater_nmpc.plan.free_space import final_straight_x
from seater_nmpc.plan.guide import Guide
from seater_nmpc.plan.planner import Planner

Array = NDArray[np.float64]

_LOOKAHEADS = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)  # fractions of `lookahead` that are tried, the farthest first
_VIEW_RESERVE = 0.08  # [rad] inside the view that the controller keeps: the chair strays from the path by as much
_ROOM = 0.6  # [m] farther ahead of the bay than usual, where the chair got stuck at its corner
_LANE_STEPS = 12  # poses between the chair and the bay at which the straight way is looked at


class Navigator:
    """Targets on the way to the corridor, all in the dock's frame. One instance may serve many dockings."""

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        control: ControlParameters,
        parameters: PlannerParameters | None = None,
        camera: CameraModel | None = None,
    ) -> None:
        """`camera`: as the controller's (see kept_field)."""
        self._dock, self._parameters = dock, parameters or PlannerParameters()
        self.field = kept_field(camera, control.view_half_angle)  # in which the controller keeps the markers
        field = self.field.narrowed(_VIEW_RESERVE)
        self._planner = Planner(chair, dock, self._parameters, control.margin, field)
        self._roomy: Planner | None = None  # made when it is needed
        self._make_roomy = lambda: Planner(chair, dock, self._parameters, control.margin, field, room=_ROOM)
        self._gate_x = final_straight_x(chair, dock)
        self._guide: Guide | None = None
        self._tried = False

    def prepare(self) -> None:
        """Do the search now that the first plan needs."""
        self._planner.prepare()

    def restart(self) -> None:
        """Forget the plan, as at the beginning of an approach."""
        self._guide, self._tried = None, False

    def give_room(self) -> None:
        """Plan ways that leave the surroundings of the bay's corners and come straight from farther ahead, where there
        are such: the chair got stuck. For a standing chair, as it takes as long as a search."""
        if self._roomy is None:
            self._roomy = self._make_roomy()
            self._roomy.set_obstacles(self._planner.obstacles)
            self._roomy.prepare()
        self.restart()

    def as_usual(self) -> None:
        """Plan the quickest ways again."""
        self._roomy = None

    def see(self, obstacles: list[Array]) -> None:
        """The obstacles of this cycle, convex polygons (n, 2). When they moved onto the way, the next target comes from
        a new plan; while the way is clear of them it is kept, as a search takes several control cycles."""
        if not _moved(self._planner.obstacles, obstacles, self._parameters.obstacle_shift):
            return
        for planner in (self._planner, *([self._roomy] if self._roomy is not None else [])):
            planner.set_obstacles(obstacles)
        if self._guide is None or not self._planner.clear_of_obstacles(self._guide.rest()):
            self.restart()

    def target(self, pose: ArrayLike) -> Array | None:
        """The pose to drive to from `pose`; None when there is no way (that the search knows of)."""
        if self._guide is not None and self._guide.away(pose) > self._parameters.replan_distance:
            self.restart()
        if not self._tried:
            path, self._tried = None if self._roomy is None else self._roomy.path(pose), True
            path = self._planner.path(pose) if path is None else path
            self._guide = None if path is None else Guide(path, self._parameters)
        if self._guide is None:
            return None
        return self._farthest(self._guide, np.asarray(pose, dtype=float))

    def _farthest(self, guide: Guide, pose: Array) -> Array:
        """The farthest target on the way that the chair can drive straight to: behind the corner of an obstacle, the
        controller would not find its way round."""
        if not self._planner.obstacles:
            return guide.target(pose, math.inf)
        for fraction in _LOOKAHEADS:
            target = guide.target(pose, fraction * self._parameters.lookahead)
            if self._planner.clear_of_obstacles(_between(pose, target)):
                break
        return target

    def blocked(self) -> bool:
        """Whether walls and obstacles leave no way into the bay, wherever the chair is."""
        return not self._planner.open

    @property
    def reason(self) -> str:
        """Why there is no way, in words for the person who asked for the docking; empty while there is one."""
        return self._planner.reason

    def straight_way_clear(self, pose: ArrayLike) -> bool:
        """Whether obstacles leave the straight way from `pose` to the bay, and on to the dock, free."""
        if not self._planner.obstacles:
            return True
        fraction = np.linspace(0.0, 1.0, _LANE_STEPS)[:, None]
        pose = np.asarray(pose, dtype=float)
        gate = np.array([max(self._gate_x, pose[0]), 0.0, 0.0])
        return self._planner.clear_of_obstacles(np.vstack([pose + fraction * (gate - pose), (1.0 - fraction) * gate]))


def _between(start: Array, end: Array) -> Array:
    """Poses (n, 3) of a straight drive from one pose to the other, turning evenly."""
    step = end - start
    step[2] = wrap_angle(float(step[2]))
    return start + np.linspace(0.0, 1.0, _LANE_STEPS)[:, None] * step


def _moved(before: list[Array], now: list[Array], shift: float) -> bool:
    """Whether any outline is new, gone, or has a corner that moved by more than `shift` [m]."""
    if len(before) != len(now):
        return True
    return any(len(a) != len(b) or _shift(a, b) > shift for a, b in zip(before, now, strict=True))


def _shift(before: Array, now: Array) -> float:
    """Largest change of a coordinate [m], whichever corner the outlines begin with: for upright boxes noise decides."""
    return min(float(np.max(np.abs(np.roll(before, i, axis=0) - now))) for i in range(len(before)))
