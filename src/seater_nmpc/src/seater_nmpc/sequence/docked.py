"""Whether the chair stands docked, with or without a goal: by contact, images, results of goals and odometry. No ROS.

Nothing is remembered beyond the run of the program: what contact and images do not show is not known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, Tolerance
from seater_common.se2 import relative
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.parameters import SequenceParameters
from seater_nmpc.sequence.rest.verification import within

Array = NDArray[np.float64]

_LEFT = 2.0  # times the tolerance of the contact: a chair so far away has left, whatever the noise of the estimate
_DRIVEN = 0.5  # [m] no docked chair drives so far, and odometry of a standing one does not drift so far
_SEEN = 1.0  # [s] since the last image: it shows where the chair stands


class Docked(IntEnum):
    """The numbers of seater_msgs/DockState."""

    UNKNOWN = 0
    NOT_DOCKED = 1
    DOCKED = 2


@dataclass(frozen=True, kw_only=True)
class DockState:
    """What is known."""

    docked: Docked
    dock: str  # where; empty: not docked, or not known which dock it is
    since: float  # message time [s]
    contact: bool | None  # None: not known
    reason: str


_NOTHING = DockState(
    docked=Docked.UNKNOWN, dock="", since=0.0, contact=None, reason="neither contact nor images have told yet"
)


class DockWatch:
    """`use` a dock, then `update` once per control cycle and tell it of goals that were `reached`."""

    def __init__(self, *, require_contact: bool) -> None:
        """`require_contact`: a chair without the contact is not taken for docked by images alone."""
        self._require_contact = require_contact
        self.forget()

    def use(self, chair: Chair, dock: Dock, observer: DockObserver, parameters: SequenceParameters) -> None:
        """The dock that is looked for from now on, with what the core knows of it."""
        self._chair, self._dock, self._observer, self._parameters = chair, dock, observer, parameters

    def forget(self) -> None:
        """What was known is void: time went backward, or the dock's file has changed."""
        self.state = _NOTHING
        self._stood: Array | None = None  # in odom (3,): where it stood docked, or began

    def reached(self, now: float, *, docked: bool) -> None:
        """A goal has docked the chair, or undocked it, at message time `now` [s]."""
        if docked:
            self._set(now, Docked.DOCKED, self._dock.name, "a goal has docked it")
            self._stood = self._pose
        else:
            self._set(now, Docked.NOT_DOCKED, "", "a goal has undocked it")

    def update(self, now: float, contact: bool | None, *, goal: bool) -> DockState:
        """As of message time `now` [s]; `contact`: None where not known; `goal`: one is being worked on, whose result
        will say whether it has docked."""
        self.state = replace(self.state, contact=contact)
        pose = self._pose
        if pose is None:
            return self.state
        if self._stood is None:
            self._stood = pose
        error = self._error(pose)
        if contact:
            self._closed(now, pose, error)
        elif self.state.docked is Docked.DOCKED:
            self._has_it_left(now, pose, error)
        else:
            self._is_it_there(now, pose, error, goal)
        return self.state

    def why_not_to(self, name: str, *, search: bool) -> str:
        """Why the chair must not set out for this dock, in words; empty: it may. `search`: by a rough pose, before the
        dock is seen. The way to another dock knows nothing of the walls round the chair."""
        state = self.state
        if state.docked is Docked.DOCKED and state.dock not in ("", name):
            return f"the chair stands docked at {state.dock}: undock first"
        if state.docked is Docked.DOCKED and not state.dock and search:
            return "the chair stands docked, not known where: undock first"
        if name != self._dock.name and self._in_bay():
            return f"the chair stands in the bay of {self._dock.name}: undock first"
        return ""

    def _closed(self, now: float, pose: Array, error: Array | None) -> None:
        """The contact says docked; images, or what was known before, say where."""
        here = error is not None and within(error, _left(self._dock))
        dock = self._dock.name if here else self.state.dock
        self._set(now, Docked.DOCKED, dock, "the charging contact is closed")
        self._stood = pose

    def _has_it_left(self, now: float, pose: Array, error: Array | None) -> None:
        limits = _left(self._dock)
        assert self._stood is not None  # set before
        if not within(relative(self._stood, pose), limits):
            self._set(now, Docked.NOT_DOCKED, "", "it has moved away")
        elif error is not None and self.state.dock == self._dock.name and not within(error, limits):
            self._set(now, Docked.NOT_DOCKED, "", "images show the dock elsewhere")

    def _is_it_there(self, now: float, pose: Array, error: Array | None, goal: bool) -> None:
        newest = self._observer.odometry.newest
        assert self._stood is not None and newest is not None  # there is a pose
        stands = abs(newest.v) <= self._parameters.standing_speed
        by_images = stands and not goal and not self._require_contact
        if error is not None and by_images and within(error, self._dock.tolerance):
            self._set(now, Docked.DOCKED, self._dock.name, "images show it there")
            self._stood = pose
        elif error is not None and not within(error, _left(self._dock)):
            self._set(now, Docked.NOT_DOCKED, "", "images show the dock elsewhere")
        elif self.state.docked is Docked.UNKNOWN and math.dist(self._stood[:2], pose[:2]) > _DRIVEN:
            self._set(now, Docked.NOT_DOCKED, "", "it has driven since")

    def _set(self, now: float, docked: Docked, dock: str, reason: str) -> None:
        """A state keeps the time and reason with which it began."""
        if (docked, dock) == (self.state.docked, self.state.dock):
            return
        since = self.state.since if docked is self.state.docked else now
        self.state = replace(self.state, docked=docked, dock=dock, since=since, reason=reason)

    @property
    def _pose(self) -> Array | None:
        newest = self._observer.odometry.newest
        return None if newest is None else newest.pose

    def _error(self, pose: Array) -> Array | None:
        """The chair in the dock's frame (3,), as images of late show it; None: they do not."""
        estimate = self._observer.estimate()
        if estimate is None or estimate.age > _SEEN or self._observer.images.contradict:
            return None
        return relative(estimate.pose, pose)

    def _in_bay(self) -> bool:
        """As far as it is known by images and odometry, however long ago."""
        estimate, pose = self._observer.estimate(), self._pose
        if estimate is None or pose is None:
            return False
        corners, bay = self._chair.corners_at(relative(estimate.pose, pose)), self._dock.bay
        beside = 0.5 * bay.width + bay.wall_thickness
        return bool(np.any((corners[:, 0] > bay.entrance_x) & (np.abs(corners[:, 1]) < beside)))


def _left(dock: Dock) -> Tolerance:
    contact = dock.contact_tolerance
    return Tolerance(_LEFT * contact.position, _LEFT * contact.heading)
