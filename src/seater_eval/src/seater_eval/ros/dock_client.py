"""Sends the dock action to a paused simulation, lets it run and follows it.

Everything waits in wall time: while the simulation is paused, ROS time stands still.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import actionlib
import rosgraph
import rospy
from actionlib import CommState
from actionlib_msgs.msg import GoalStatus
from std_srvs.srv import SetBool

from seater_eval.ros.connections import is_connected, links
from seater_msgs.msg import DockAction, DockFeedback, DockGoal, DockResult


class DockClientError(RuntimeError):
    """The system did not start, or stopped answering."""


def wait_until(condition: Callable[[], bool], what: str, alive: Callable[[], bool], timeout: float) -> None:
    """Polls in wall time; raises DockClientError when the time is over or the system has ended."""
    end = time.monotonic() + timeout
    while not _holds(condition):
        if not alive():
            raise DockClientError(f"the launch ended while waiting for {what}")
        if time.monotonic() > end:
            raise DockClientError(f"waited {timeout:.0f} s for {what}")
        time.sleep(0.02)


def _holds(condition: Callable[[], bool]) -> bool:
    """False, too, when a node or the master cannot be reached: it is ending, or has not begun."""
    try:
        return condition()
    except OSError:
        return False


class DockClient:
    """One docking; `alive` tells whether the system still runs."""

    def __init__(self, alive: Callable[[], bool]) -> None:
        self._alive = alive
        self._client: Any = None
        self._goal: Any = None
        self.feedback: DockFeedback | None = None

    def connect(self, timeout: float) -> None:
        """Master, simulated time and action server are there and connected."""
        wait_until(rosgraph.is_master_online, "the ROS master", self._alive, timeout)
        master = rosgraph.Master("dock_run")
        wait_until(lambda: bool(master.hasParam("/use_sim_time")), "the launch file's parameters", self._alive, timeout)
        rospy.init_node("dock_run", anonymous=True, disable_signals=True)
        action = self._client = actionlib.ActionClient("dock", DockAction)
        ends = (action.pub_goal, action.pub_cancel, action.status_sub, action.feedback_sub, action.result_sub)
        wait_until(lambda: all(e.get_num_connections() > 0 for e in ends), "the dock action", self._alive, timeout)

    def wait_for_recorder(self, node: str, timeout: float) -> None:
        """Until `node` hears everything that is being published of what it subscribed to."""
        master = rosgraph.Master("dock_run")

        def recording() -> bool:
            wanted = links(master, subscriber=node)
            others = [link for link in wanted if link[0] != rospy.get_name()]
            return bool(wanted) and all(is_connected(master, *link) for link in others)

        wait_until(recording, f"{node} to hear everyone", self._alive, timeout)

    def start(self, timeout: float) -> None:
        """Sends the goal while time stands still, then lets time run: the same start every time."""
        wait_until(lambda: rospy.get_time() > 0.0, "the simulator's clock", self._alive, timeout)
        self.run(False)  # answers when all are connected and the docking node has its first odometry
        self.send(timeout)
        self.run(True)

    def send(self, timeout: float = 10.0) -> None:
        """Sends the goal and waits for an answer; of a simulation that runs freely."""
        self._goal = self._client.send_goal(DockGoal(use_dock_id=True, dock_id=""), feedback_cb=self._on_feedback)
        wait_until(lambda: self._state() != GoalStatus.PENDING, "an answer to the goal", self._alive, timeout)

    def run(self, on: bool) -> None:
        """Lets simulated time run or pauses it."""
        rospy.wait_for_service("sim/run", timeout=None)
        rospy.ServiceProxy("sim/run", SetBool)(on)

    def cancel(self) -> None:
        if self._client is not None:
            self._client.cancel_all_goals()

    def done(self) -> bool:
        """Whether the goal has ended and its result has arrived."""
        return self._goal.get_comm_state() == CommState.DONE

    def result(self) -> DockResult | None:
        return self._goal.get_result()

    def _state(self) -> int:
        return int(self._goal.get_goal_status())

    def _on_feedback(self, _: Any, feedback: DockFeedback) -> None:
        self.feedback = feedback
