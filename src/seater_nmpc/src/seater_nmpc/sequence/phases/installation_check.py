"""CHECK_INSTALLATION: turns in front of the bay, where it is not known well enough where the camera sits on the chair.

At a place far from the dock and at one near it: either alone leaves the camera's x and the focal length together.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.sight import Sight
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import Asked, Context
from seater_nmpc.sequence.phases.swing import Swing
from seater_nmpc.sequence.phases.way_out import WayOut

Array = NDArray[np.float64]

_FAR_ENOUGH = 0.4  # [m] short of the far place, where the chair may turn as well
_ELSEWHERE = 0.25  # [m] from where it has turned before: a slippery place under one wheel would show again
_BOTH = 2  # places, far and near
_NEAR = 0.06  # [m] from a place
_LONGEST = 20.0  # [s] on the way to a place: then it turns where it is
_TURNS = "turns to both sides and back: the markers show where the camera sits on the chair"
_GOES = "on its way to turn in front of the dock, which shows where the camera sits on the chair"


class InstallationCheck:
    """Errors (3,): the chair in the dock's frame. Places: x [m] there, in front of the bay."""

    def __init__(self, context: Context, way_out: WayOut) -> None:
        self._context, self._way_out = context, way_out
        self._sight = Sight(context.chair.camera, context.dock, context.navigator.field)
        self.begin()

    def begin(self) -> None:
        """A goal begins."""
        self._turned: list[bool] = []  # at which places, far or near, room or not
        self._begun = 0
        self._forgotten = False  # what a turn has shown
        self._swings = 0  # turns made, of those that are not forgotten
        self.restart()

    def restart(self) -> None:
        """A phase begins."""
        self._swing: Swing | None = None
        self._place: float | None = None  # where it goes to turn
        self._until = 0.0  # [s] it has to be there
        self.backs_out = False  # to there

    def wanted(self, error: Array, *, straight: bool) -> bool:
        """Whether the chair is to turn before it goes on from here; `straight`: the rest is driving straight in.

        What a goal has begun it ends, as one place says too little; nothing begins after half of the goal's time.
        """
        c, p, turned = self._context, self._context.parameters, len(self._turned)
        if p.installation_check == "never" or c.goal.staging or turned >= p.installation_turns:
            return False
        if c.goal.now > c.goal.deadlines.half:
            return False
        begun = c.watch.installation.begun
        if begun != self._begun:  # the dock was another one, or lost: what was turned before shows nothing
            self._forgotten = self._forgotten or turned > 0
            self._turned, self._begun, turned, self._swings = [], begun, 0, 0
        # The contact says it better.
        known = c.require_contact or c.watch.installation.doubt(turned=turned > 0) <= p.installation_doubt
        begins = turned == 0 and p.installation_check == "always"
        if known and turned != 1 and not begins:
            return False
        begins_here = turned == 0 and self._is_far(error) and self._has_room(error)
        if self._on_the_way and (turned == 0 or turned > _BOTH):  # nowhere that it would have to back out far to
            return begins_here or (straight and turned == 0 and self._forgotten)
        if self._on_the_way and not self._turned[0]:  # what the turn far away had shown is forgotten: the near one did
            return False
        return straight or begins_here

    @property
    def vouches(self) -> bool:
        """Whether a success has to be as certain as turns make it."""
        never = self._context.parameters.installation_check == "never"
        return not never and (not self._on_the_way or len(self._turned) >= _BOTH)

    @property
    def shown(self) -> bool:
        """Whether it has turned at two places."""
        return self._swings >= _BOTH

    @property
    def _on_the_way(self) -> bool:
        return self._context.parameters.installation_check == "on_the_way"

    def check(self, chair: Instant) -> Asked:
        """CHECK_INSTALLATION: to a place in front of the bay, and turn there to both sides. Raises GoalEnd."""
        c = self._context
        error = c.look(chair)
        if self._swing is None:
            asked = self._go(chair, error)
            if asked is not None:
                return asked
            self._turned.append(self._is_far(error))
            if not self._has_room(error):
                return Phase.APPROACH
            self._swing = Swing(c.chair, c.dock, self._sight)
            c.controller.reset()
        speeds = self._swing.speeds(chair.stamp, error, c.rest_error(chair), c.controller.obstacles)
        if speeds is None:
            return self._turned_there()
        return replace(c.controller.move(chair.stamp, c.speeds(chair), *speeds), text=_TURNS)

    def _turned_there(self) -> Phase:
        """A chair whose installation is surely wrong does not drive into the bay. Raises GoalEnd."""
        self._context.controller.reset()
        self._swings += 1
        wrong = self._context.watch.installation.final()
        if wrong is not None:
            raise GoalEnd(ResultCode[wrong.kind.name], f"turned in front of the dock: {wrong.text}")
        return Phase.APPROACH

    def _go(self, chair: Instant, error: Array) -> Asked | None:
        """On the way to the place; None: there, or as near as it gets."""
        c = self._context
        if self._place is None:
            self._place = self._next(error)
            self.backs_out = bool(error[0] > self._place + _NEAR)
            self._until = chair.stamp + min(_LONGEST, c.parameters.back_out_wait)
        there = error[0] <= self._place + _NEAR if self.backs_out else error[0] >= self._place - _NEAR
        if there or chair.stamp > self._until:
            self.backs_out = False
            return None
        target = np.array([self._place, 0.0, 0.0])
        drive = self._way_out.back_out(chair, error, target) if self.backs_out else c.drive(chair, target)
        return replace(drive, text=_GOES) if drive.v != 0.0 else drive  # else it waits, and says for what

    def _next(self, error: Array) -> float:
        """The place to turn at."""
        if not self._turned and self._is_far(error):
            return float(error[0])
        to_far = bool(self._turned) and not self._turned[-1] and not self._on_the_way
        elsewhere = _ELSEWHERE * (len(self._turned) // 2)
        return self._far + elsewhere if to_far else self._context.dock.predock_x - elsewhere

    @property
    def _far(self) -> float:
        return self._context.dock.predock_x - self._context.parameters.installation_way

    def _is_far(self, error: Array) -> bool:
        return bool(error[0] < self._far + _FAR_ENOUGH)

    def _has_room(self, error: Array) -> bool:
        return Swing(self._context.chair, self._context.dock, self._sight).has_room(
            error, self._context.controller.obstacles
        )
