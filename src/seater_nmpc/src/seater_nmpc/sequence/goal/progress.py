"""How far a goal has come, and what others say of the chair meanwhile."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_nmpc.parameters import Timeouts
from seater_nmpc.sequence.goal.deadlines import Deadlines
from seater_nmpc.sequence.goal.results import GoalEnd, Phase

Array = NDArray[np.float64]


class Progress:
    """Of one goal after another: `begin` each. Poses are (x, y, heading) [m, m, rad]."""

    def __init__(self, timeouts: Timeouts) -> None:
        self.timeouts = timeouts  # of the next goal
        self.contact: bool | None = None  # the charging contact, None: not known
        self.force = False  # undock from here, whatever is known
        self.staging = False  # the goal ends at the predock point
        self.unsure = ""  # why it is not known what is in the way; empty: it is
        self.held_by = ""  # why the safety gate holds the chair; empty: it does not
        self.begin(0.0, Phase.WAITING_FOR_DOCK, 0.0)

    def begin(self, now: float, phase: Phase, timeout: float) -> None:
        """A goal begins at message time `now` [s] with this phase; it may take `timeout` [s]."""
        self.now, self.phase, self.retries = now, phase, 0
        self.deadlines = Deadlines(self.timeouts, now, timeout)
        self.error: Array | None = None  # (3,) the chair in the dock's frame, once known
        self.covariance: Array | None = None  # (3, 3) of the error, by the images alone, once verified
        self.T_odom_dock: Array | None = None
        self.failure: GoalEnd | None = None  # what the goal will end with, when the chair has backed out
        self.no_way = ""  # why there is no way into the bay
        # Where a stop was to end: ahead of the dock [m], and its heading [rad].
        self.expected_rest: tuple[float, float] | None = None
        self.overshoot = 0.0  # [m] beyond where its last stop at the dock was to end
        self.overturn = 0.0  # [rad] the same of its heading

    def enter(self, phase: Phase) -> None:
        """A phase begins."""
        self.phase = phase
        self.deadlines.enter(self.now)
