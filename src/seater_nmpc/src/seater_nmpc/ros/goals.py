"""The actions `dock` and `undock`: at most one goal at a time, and every goal gets a result with a code."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import Any

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus

from seater_common.inputs.node_lives import node_lives
from seater_msgs.msg import DockAction, UndockAction
from seater_nmpc.ros import conversions
from seater_nmpc.sequence.goal.results import Result, ResultCode, Step

PING_PERIOD = 0.5  # [s] of wall time
SHORTEST = 2.0  # [s] of silence that means something


class Goals:
    """Both action servers. A second `dock` (or `undock`) replaces the first one; the other action meanwhile is BUSY.

    Callbacks of actionlib's threads only hand over to `enqueue(kind, content)`; all else runs in the worker's thread.
    """

    def __init__(self, enqueue: Callable[[str, Any], None]) -> None:
        self._handle: Any = None
        self.kind = ""
        self._servers = {}
        for kind, action in (("dock", DockAction), ("undock", UndockAction)):
            self._servers[kind] = actionlib.ActionServer(
                kind,
                action,
                goal_cb=lambda handle, kind=kind: enqueue("goal", (kind, handle)),
                cancel_cb=lambda handle: enqueue("cancel", handle),
                auto_start=False,
            )

    def start(self) -> None:
        """Advertise both actions: from now on the node is ready."""
        for server in self._servers.values():
            server.start()

    @property
    def active(self) -> bool:
        """Whether a goal is being worked on."""
        return self._handle is not None

    def is_current(self, handle: Any) -> bool:
        """Whether this is the goal that is being worked on."""
        return self._handle is not None and self._handle == handle

    def accept(self, kind: str, handle: Any) -> None:
        """Make this the goal that is worked on."""
        handle.set_accepted()
        self._handle, self.kind = handle, kind

    def refuse(self, kind: str, handle: Any, code: ResultCode, text: str) -> None:
        """Answer a goal that is not worked on: rejected, or recalled where it was cancelled while waiting."""
        recalled = handle.get_goal_status().status == GoalStatus.RECALLING
        result = _message(kind, Result(code=ResultCode.CANCELED if recalled else code, text=text))
        (handle.set_canceled if recalled else handle.set_rejected)(result, text)
        rospy.logwarn("%s goal refused: %s (%s)", kind, text, code.name)

    def publish(self, step: Step) -> None:
        """Feedback of the goal, and its result when this is the last step."""
        if self._handle is None:
            return
        docking = self.kind == "dock"
        self._handle.publish_feedback(conversions.dock_feedback(step) if docking else conversions.undock_feedback(step))
        if step.result is None:
            return
        result = step.result
        message, text = _message(self.kind, result), f"{result.code.name}: {result.text}"
        if result.code is ResultCode.CANCELED:
            self._handle.set_canceled(message, text)
        elif result.success:
            self._handle.set_succeeded(message, text)
        else:
            self._handle.set_aborted(message, text)
        rospy.loginfo("%s: %s", self.kind, text)
        self._handle, self.kind = None, ""


class ClientWatch:
    """Whether the node that gave the goal lives, in a thread of its own: it is asked as `rosnode ping` does.

    A client that gives goals for others (rosbridge, say) lives on when they are gone.
    """

    def __init__(self, timeout: float, lives: Callable[[str], bool] | None = None) -> None:
        """`timeout` [s] of wall time: how long it may be silent; 0: nobody is watched. `lives`: asks the node of this
        name; None: over the network.

        Raises:
            ValueError: a time-out that is shorter than an answer may take.
        """
        if 0.0 < timeout < SHORTEST:
            raise ValueError(f"sequence/client_timeout: is {timeout}, must be 0 or at least {SHORTEST} [s]")
        self._timeout, self._lives = timeout, lives or (lambda name: node_lives(name, rospy.get_name()))
        self._client, self._answered = "", 0.0
        if timeout > 0.0:
            threading.Thread(target=self._work, daemon=True).start()

    def begin(self, goal: Any) -> None:
        """A goal begins: the action's message with it, which names its sender."""
        self._answered = time.monotonic()
        self._client = getattr(goal, "_connection_header", {}).get("callerid", "") if self._timeout > 0.0 else ""

    def end(self) -> None:
        """The goal has ended."""
        self._client = ""

    def lost(self) -> str:
        """Why the goal has no owner any more, in words; empty: it has, or nobody is watched."""
        client, silence = self._client, time.monotonic() - self._answered
        if not client or silence <= self._timeout:
            return ""
        return f"{client}, which gave the goal, has not answered for {silence:.1f} s"

    def _work(self) -> None:
        while not rospy.is_shutdown():
            client = self._client
            if client and self._lives(client) and client == self._client:
                self._answered = time.monotonic()
            time.sleep(PING_PERIOD)


def valid_timeout(timeout: float) -> bool:
    """Whether a goal's time-out can be used."""
    return math.isfinite(timeout) and timeout >= 0.0


def _message(kind: str, result: Result) -> Any:
    return conversions.dock_result(result) if kind == "dock" else conversions.undock_result(result)
