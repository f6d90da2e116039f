"""WAITING_FOR_DOCK and SEARCHING: until the dock is in view, and the chair in front of the bay."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import relative
from seater_nmpc.observe.observer import DockEstimate
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.plan.front import Front
from seater_nmpc.sequence.goal.results import GoalEnd, Phase, ResultCode
from seater_nmpc.sequence.phases.context import IMAGES_THAT_MAY_FAIL, STANDING, Asked, Context
from seater_nmpc.sequence.phases.search import SWEEPS, Search
from seater_nmpc.sequence.phases.way_in import WayIn
from seater_nmpc.sequence.rest.verification import within

Array = NDArray[np.float64]

_WELL_IN_FRONT = 0.3  # [m] nearer to the bay or farther from it, the side wall would (not) hide the markers either
_ASIDE = 0.35  # [rad] of the camera's axis, from which on markers may be out of view
_LOOKS = 2  # times that it is looked for after it was lost on the approach
_SEEN_NOW = 0.5  # [s] or a few images: a dock seen so lately is in view


class Finding:
    """Of the dock, at the beginning of a goal, or when the chair has turned away from it on the approach."""

    def __init__(self, context: Context, way_in: WayIn) -> None:
        self._context, self._way_in = context, way_in
        self._front = Front(context.chair, context.dock)
        self.begin()

    def begin(self) -> None:
        """A goal begins."""
        self._rough: Array | None = self._context.observer.prior  # the dock in odom (3,), where it is looked for
        self.resume()

    def resume(self) -> None:
        """A goal goes on from wherever the chair is now."""
        self._lost = 0  # times that it was out of sight on the approach, and looked for
        self._went_round = False  # to the front of the bay, as far as the way is clear
        self.restart()

    def restart(self) -> None:
        """A phase begins."""
        self._search: Search | None = None

    def wait(self, chair: Instant) -> Asked:
        """WAITING_FOR_DOCK: stand until the dock is in view, or, with a rough pose of it, until it is searched for."""
        c, p = self._context, self._context.parameters
        if not c.in_view(chair):
            waited = c.goal.now - c.goal.deadlines.entered
            return Phase.SEARCHING if self._rough is not None and waited >= p.search_after else STANDING
        error = c.look(chair)
        if math.hypot(error[0], error[1]) > p.max_start_distance:
            raise GoalEnd(ResultCode.DOCK_NOT_VALID, f"the dock is {math.hypot(error[0], error[1]):.1f} m away")
        docks = not c.goal.staging
        if docks and within(error, c.dock.tolerance) and (c.goal.contact or not c.require_contact):
            raise GoalEnd(ResultCode.ALREADY_DOCKED, "already docked")
        if self._front.hidden(error - [_WELL_IN_FRONT, 0.0, 0.0]) and not self._went_round:
            return Phase.SEARCHING
        return self._way_in.first_phase(error)

    def find(self, chair: Instant) -> Asked:
        """SEARCHING: look for the dock by the rough pose; as soon as it is found, go on as if it had been in view.

        Where it is seen from beside the bay only, drive round to the front first.
        """
        c, known = self._context, self._context.in_view(chair)
        if known and self._seen_now(chair) and self._may_go_on(c.look(chair)):
            return self.wait(chair)
        self._rough = c.goal.T_odom_dock if known else self._rough
        assert self._rough is not None  # or there would be nothing to look for
        here, speeds = relative(self._rough, chair.pose), c.speeds(chair)
        if self._search is None:
            self._search = self._begin_search(known, here)
        rest = c.rest_from(self._rough, chair, speeds)
        asked = self._search.speeds(chair.stamp, here, rest, c.controller.obstacles, rough=not (known or self._lost))
        if asked is not None:
            return c.controller.move(chair.stamp, speeds, *asked)
        if not known:
            raise self._in_vain()
        self._went_round = True  # as far as it could
        return self.wait(chair)

    def turned_away(self, chair: Instant, estimate: DockEstimate) -> bool:
        """Whether the dock may be out of view because the chair has turned too far, on the approach or to see where the
        camera sits, and is to be looked for: twice in a goal."""
        if self._context.goal.phase not in (Phase.APPROACH, Phase.CHECK_INSTALLATION) or self._lost >= _LOOKS:
            return False
        return abs(self._front.aside(relative(estimate.pose, chair.pose))) > _ASIDE

    def turn_back(self, T_odom_dock: Array) -> Phase:
        """The chair is to look for the dock where it was seen last (3,). The second time from straight ahead of the
        bay: the way that led out of sight would do so again, as where a side wall begins to hide the markers."""
        self._lost, self._rough = self._lost + 1, T_odom_dock
        return Phase.SEARCHING

    def _begin_search(self, known: bool, here: Array) -> Search:
        c = self._context
        at_once = known or self._lost == _LOOKS  # round to the front
        first = () if at_once else SWEEPS[:1] if self._lost or self._front.hidden(here) else SWEEPS
        return Search(c.chair, c.dock, c.observer.images.period, first=first, go=at_once or not self._lost)

    def _in_vain(self) -> GoalEnd:
        why = self._context.observer.images.why_unseen
        if self._lost:
            return GoalEnd(ResultCode.MARKER_LOST, f"turned back to it in vain: {why}")
        return GoalEnd(ResultCode.FAILED_TO_DETECT_DOCK, f"looked all round for it: {why}")

    def _may_go_on(self, error: Array) -> bool:
        if self._lost == _LOOKS and abs(error[1]) > 0.5 * self._context.dock.bay.width:
            return False  # round to the front first
        return self._well_in_front(error)

    def _well_in_front(self, error: Array) -> bool:
        """Whether the markers can be seen nearer and farther, too: then waiting does not send it to search again."""
        return not any(self._front.hidden(error + [shift, 0.0, 0.0]) for shift in (_WELL_IN_FRONT, -_WELL_IN_FRONT))

    def _seen_now(self, chair: Instant) -> bool:
        estimate = self._context.observer.estimate(chair.stamp)
        lately = max(_SEEN_NOW, IMAGES_THAT_MAY_FAIL * self._context.observer.images.period)
        return estimate is not None and estimate.age <= lately
