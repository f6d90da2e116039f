"""A chair that runs, as a session of dockings sees it: the actions `dock` and `undock`."""

from __future__ import annotations

import time
from typing import Any

import actionlib
import rospy
from actionlib import CommState
from actionlib_msgs.msg import GoalStatus

from seater_msgs.msg import DockAction, DockGoal, UndockAction, UndockGoal
from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.repeat.session import Docked, Undocked

CONNECT = 5.0  # [s] for the docking node to answer
STAND = 5.0  # [s] for a cancelled goal to end
_POLL = 0.05  # [s] on the wall


class NoChairError(RuntimeError):
    """Nobody answers."""


class RunningChair:
    """Waits on the wall's clock: message time may stand still."""

    def __init__(self, dock_id: str) -> None:
        """Raises NoChairError."""
        self._goal = DockGoal(use_dock_id=True, dock_id=dock_id)
        self._dock = self._client("dock", DockAction)
        self._undock = self._client("undock", UndockAction)

    def dock(self) -> Docked:
        """Raises NoChairError when the node is gone."""
        r = self._ask(self._dock, self._goal)
        if r is None:
            return Docked(code=int(ResultCode.BUSY), text="the docking node has rejected the goal", duration=0.0)
        return Docked(
            code=r.result_code,
            text=r.result_text,
            duration=r.docking_time,
            retries=r.num_retries,
            contact=r.contact,
            x=r.longitudinal_error,
            y=r.lateral_error,
            heading=r.heading_error,
            position_sd=r.position_sd,
            heading_sd=r.heading_sd,
        )

    def undock(self) -> Undocked:
        """The same."""
        r = self._ask(self._undock, UndockGoal())
        if r is None:
            return Undocked(code=int(ResultCode.BUSY), text="the docking node has rejected the goal")
        return Undocked(code=r.result_code, text=r.result_text)

    def _client(self, name: str, kind: Any) -> Any:
        client = actionlib.ActionClient(name, kind)
        end = time.monotonic() + CONNECT
        while not client.wait_for_server(rospy.Duration.from_sec(_POLL)):
            if time.monotonic() > end or rospy.is_shutdown():
                raise NoChairError(f"no docking node answers on {rospy.resolve_name(name)}: is wheelchair.launch up?")
        return client

    def _ask(self, client: Any, goal: Any) -> Any:
        """The result; None: rejected. Interrupted, it cancels the goal and waits until the chair has been stopped."""
        handle = client.send_goal(goal)
        try:
            self._wait(client, handle, None)
        except BaseException:
            handle.cancel()
            self._wait(client, handle, STAND)
            raise
        return None if handle.get_goal_status() == GoalStatus.REJECTED else handle.get_result()

    def _wait(self, client: Any, handle: Any, longest: float | None) -> None:
        """Until the result has come: the status may be final before."""
        end = None if longest is None else time.monotonic() + longest
        silent = 0
        while handle.get_comm_state() != CommState.DONE and (end is None or time.monotonic() < end):
            if rospy.is_shutdown():
                raise NoChairError("ROS was shut down")
            silent = 0 if client.status_sub.get_num_connections() else silent + 1
            if silent > CONNECT / _POLL:
                raise NoChairError("the docking node is gone; the safety gate holds zero")
            time.sleep(_POLL)
