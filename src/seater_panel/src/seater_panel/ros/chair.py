"""The way to the chair: the topic `hold_to_run` and the actions `dock` and `undock`, as any other button has it."""

from __future__ import annotations

import threading
from typing import Any

import actionlib
import rospy
from actionlib import CommState
from std_msgs.msg import Bool

from seater_msgs.msg import DockAction, DockGoal, UndockAction, UndockGoal

LOOK_PERIOD = 1.0  # [s] between two looks at the gate's parameter


class RosChair:
    """Implements seater_panel.hold.driver.Chair."""

    def __init__(self, gate: str) -> None:
        """`gate`: name of the safety gate's node, whose parameter says whether it watches the button."""
        self._button = rospy.Publisher("hold_to_run", Bool, queue_size=1, tcp_nodelay=True)
        self._clients: dict[str, Any] = {
            "dock": actionlib.ActionClient("dock", DockAction),
            "undock": actionlib.ActionClient("undock", UndockAction),
        }
        self._goal: Any = None
        self._parameter = rospy.resolve_name(f"{gate}/safety/hold_to_run")
        self._watched = False
        self._simulated = bool(rospy.get_param("/use_sim_time", False))
        threading.Thread(target=self._look, name="gate parameter", daemon=True).start()

    def tell(self, held: bool) -> None:
        """Say on `hold_to_run` whether the button is held."""
        self._button.publish(held)

    def refusal(self) -> str:
        """Why no goal can be given now; empty: it can."""
        if self._simulated:
            return "in simulated time the panel only shows: start sim.launch with lock_step:=false"
        if self._button.get_num_connections() == 0:
            return "no safety gate listens to the button"
        if not self._watched:
            return "the safety gate does not watch the button: start it with panel:=true, or hold_to_run: 1"
        if not all(self._connected(client) for client in self._clients.values()):
            return "the docking node does not run"
        return ""

    def send(self, action: str, dock: str) -> None:
        """Give a goal to the action `dock` (empty: to the configured dock) or `undock`."""
        goal = DockGoal(use_dock_id=True, dock_id=dock) if action == "dock" else UndockGoal()
        self._goal = self._clients[action].send_goal(goal)

    def cancel(self) -> None:
        """Cancel every goal of both actions."""
        for client in self._clients.values():
            client.cancel_all_goals()

    def active(self) -> bool:
        """Whether the last goal of `send` has not ended yet."""
        return self._goal is not None and self._goal.get_comm_state() != CommState.DONE

    @staticmethod
    def _connected(client: Any) -> bool:
        ends = (client.pub_goal, client.pub_cancel, client.status_sub, client.feedback_sub, client.result_sub)
        return all(end.get_num_connections() > 0 for end in ends)

    def _look(self) -> None:
        """Whether the gate was told to stop the chair when the button falls silent: else it must not drive by it."""
        while not rospy.is_shutdown():
            try:
                self._watched = float(rospy.get_param(self._parameter, 0.0)) != 0.0
            except (OSError, TypeError, ValueError, rospy.ROSException):
                self._watched = False
            rospy.rostime.wallsleep(LOOK_PERIOD)
