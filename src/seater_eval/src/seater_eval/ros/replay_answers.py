"""What perception and the docking node answer during a replay."""

from __future__ import annotations

import threading
import time
from typing import Any

import rospy
from rosgraph_msgs.msg import Log

from seater_msgs.msg import ControllerStatus, InputDone, MarkerDetectionArray

ANSWER_TIMEOUT = 10.0  # [s] wall time
REFUSED_TIMEOUT = 1.0  # [s] the same while every image so far has been refused: perception says why once a second


class ReplayError(RuntimeError):
    """The bag cannot be replayed, or a node does not answer."""


class Answers:
    """What came back, by stamp. Callbacks store, the replay waits."""

    def __init__(self) -> None:
        self._condition = threading.Condition()
        self.detections: dict[rospy.Time, MarkerDetectionArray] = {}
        self.status: list[ControllerStatus] = []
        self.last_error = ""  # of perception, as it says it in its log
        self._done: set[tuple[str, rospy.Time]] = set()
        rospy.Subscriber("detections", MarkerDetectionArray, self._on_detections, queue_size=100)
        self._perception = rospy.resolve_name("marker_detector")
        rospy.Subscriber("/rosout", Log, self._on_log, queue_size=100)
        rospy.Subscriber("controller_status", ControllerStatus, self._on_status, queue_size=1000)
        rospy.Subscriber("input_done", InputDone, self._on_done, queue_size=1000)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        with self._condition:
            self.detections[message.header.stamp] = message
            self._condition.notify_all()

    def _on_log(self, message: Log) -> None:
        if message.name == self._perception and message.level >= Log.ERROR:
            self.last_error = message.msg

    def _on_status(self, message: ControllerStatus) -> None:
        with self._condition:
            self.status.append(message)

    def _on_done(self, message: InputDone) -> None:
        with self._condition:
            self._done.add((message.input, message.header.stamp))
            self._condition.notify_all()

    def wait_for_detections(self, stamp: rospy.Time) -> bool:
        """False when perception did not answer: it refuses a bad image and says so in its log."""
        refused = self.last_error and not self.detections
        return self._wait(lambda: stamp in self.detections, REFUSED_TIMEOUT if refused else ANSWER_TIMEOUT)

    def wait_for_done(self, name: str, stamp: rospy.Time) -> None:
        if not self._wait(lambda: (name, stamp) in self._done):
            raise ReplayError(f"the docking node did not answer to {name} of {stamp.to_sec():.3f} s")

    def _wait(self, condition: Any, timeout: float = ANSWER_TIMEOUT) -> bool:
        end = time.monotonic() + timeout
        with self._condition:
            while not condition():
                if rospy.is_shutdown() or not self._condition.wait(max(0.0, end - time.monotonic())):
                    return bool(condition())
        return True
