"""The topic `dock_state`: whether the chair stands docked."""

from __future__ import annotations

import rospy
from std_msgs.msg import Header

from seater_msgs.msg import DockState as DockStateMsg
from seater_nmpc.sequence.docked import DockState

_CONTACT = {
    None: DockStateMsg.CONTACT_UNKNOWN,
    False: DockStateMsg.CONTACT_OPEN,
    True: DockStateMsg.CONTACT_CLOSED,
}


class DockStates:
    """Latched; sends what has changed only."""

    def __init__(self) -> None:
        self._publisher = rospy.Publisher("dock_state", DockStateMsg, queue_size=10, latch=True)
        self._told: DockState | None = None

    def tell(self, stamp: rospy.Time, state: DockState) -> None:
        """`stamp`: of the odometry by which it is so."""
        if state == self._told:
            return
        self._told = state
        self._publisher.publish(
            DockStateMsg(
                header=Header(stamp=stamp),
                state=int(state.docked),
                dock=state.dock,
                since=rospy.Time.from_sec(state.since),
                contact=_CONTACT[state.contact],
                reason=state.reason,
            )
        )
