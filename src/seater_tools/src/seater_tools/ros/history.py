"""The node that writes the history: it listens to the docking node and the gate, and sends nothing.

Topics in: dock/goal, dock/result, dock_in_use, innovations, velocity_request, charging_contact, /diagnostics.
Private parameters: ~file (the history), ~dock_file (for the age of its teaching), ~dock (its contents): of the
configured dock, until dock_in_use names another one.
"""

from __future__ import annotations

import datetime
import re
import threading
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from std_msgs.msg import Bool

from seater_msgs.msg import DockActionGoal, DockActionResult, DockInnovation, DockInUse
from seater_tools.history.collect import Collector, Result
from seater_tools.history.store import append

WAIT = 5.0  # [s] for the docking node's next diagnostics, which come once a second, and then without
_VALUE = re.compile(r"^(?P<value>\S+) \+- (?P<sd>\S+)$")
_KEY = "installation: "


class Recorder:
    """One lock round the collector. A line is written when the diagnostics after a result have come."""

    def __init__(self) -> None:
        self._lock, self._collector = threading.Lock(), Collector()
        self._file = Path(str(rospy.get_param("~file"))).expanduser()
        self._configured, self._dock = str(rospy.get_param("~dock_file")), str(rospy.get_param("~dock/name"))
        self._dock_file = Path(self._configured)
        self._pending: tuple[Result, datetime.datetime] | None = None
        self._active = 0  # goals that have no result yet
        self._staging: set[str] = set()  # of those that end at the predock point
        rospy.Subscriber("dock/goal", DockActionGoal, self._on_goal, queue_size=10)
        rospy.Subscriber("dock/result", DockActionResult, self._on_result, queue_size=10)
        rospy.Subscriber("dock_in_use", DockInUse, self._on_dock, queue_size=10)
        rospy.Subscriber("innovations", DockInnovation, self._on_innovation, queue_size=100)
        rospy.Subscriber("velocity_request", TwistStamped, self._on_request, queue_size=100)
        rospy.Subscriber("charging_contact", Bool, self._on_contact, queue_size=10)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=20)
        rospy.on_shutdown(lambda: self._write({}))

    def _on_goal(self, message: DockActionGoal) -> None:
        self._write({})
        with self._lock:
            if message.goal.staging_only:  # no docking
                self._staging.add(message.goal_id.id)
                return
            if self._active == 0:
                self._collector.begin()
            self._active += 1

    def _on_result(self, message: DockActionResult) -> None:
        goal, r = message.status.goal_id.id, message.result
        with self._lock:
            if goal in self._staging:
                self._staging.discard(goal)
                return
        error = (r.longitudinal_error, r.lateral_error, r.heading_error)
        result = Result(
            r.result_code, r.result_text, r.docking_time, r.num_retries, r.contact, error, r.position_sd, r.heading_sd
        )
        self._write({})
        with self._lock:
            self._active = max(0, self._active - 1)
            self._pending = (result, datetime.datetime.now(datetime.UTC))
        timer = threading.Timer(WAIT, self._write, args=({},))
        timer.daemon = True
        timer.start()

    def _on_dock(self, message: DockInUse) -> None:
        """The next goals are about this dock. A source that is no file is the parameter's, whose file is known."""
        self._write({})  # of the dock before
        with self._lock:
            is_file = message.source.endswith(".yaml")
            self._dock, self._dock_file = message.name, Path(message.source if is_file else self._configured)

    def _on_innovation(self, m: DockInnovation) -> None:
        with self._lock:
            if self._active:
                self._collector.innovation(m.outcome, m.accepted, m.x, m.y, m.nis)

    def _on_request(self, message: TwistStamped) -> None:
        with self._lock:
            if self._active:
                self._collector.asked(message.twist.linear.x)

    def _on_contact(self, message: Bool) -> None:
        with self._lock:
            if self._active and message.data:
                self._collector.contact(True)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name.endswith(": sequence"):
                found = {entry.key: _VALUE.match(entry.value) for entry in status.values if entry.key.startswith(_KEY)}
                self._write({k.removeprefix(_KEY): (float(m["value"]), float(m["sd"])) for k, m in found.items() if m})

    def _write(self, installation: dict[str, tuple[float, float]]) -> None:
        """The line of the result that waits, if there is one."""
        with self._lock:
            if self._pending is None:
                return
            (result, now), self._pending = self._pending, None
            text = self._dock_file.read_text() if self._dock_file.is_file() else ""
            docking = self._collector.finish(result, self._dock, text, now, installation)
            self._collector.begin()
            try:
                append(self._file, docking)
            except OSError as error:
                rospy.logerr("the history of dockings is not written: %s", error)
