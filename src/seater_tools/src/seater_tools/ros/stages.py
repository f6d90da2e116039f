"""The newest word of each entry on /diagnostics."""

from __future__ import annotations

import threading
import time

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray

from seater_tools.stages.tree import Entry, Level

TOPIC = "/diagnostics"
LONGEST_CONNECTING = 5.0  # [s] a node that died without a word stays known to the master and never connects


class Ear:
    """Listens from its construction on. Ages by a clock that nobody can set."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._heard: dict[str, tuple[float, Entry]] = {}
        self._subscriber = rospy.Subscriber(TOPIC, DiagnosticArray, self._take, queue_size=50)

    def wait_for_publishers(self) -> None:
        """Until all that publish now are connected: on a loaded computer that takes longer than a report's period."""
        published = dict(rosgraph.Master(rospy.get_name()).getSystemState()[0])
        count, end = len(published.get(rospy.resolve_name(TOPIC), ())), time.monotonic() + LONGEST_CONNECTING
        while self._subscriber.get_num_connections() < count and time.monotonic() < end:
            time.sleep(0.02)

    def _take(self, message: DiagnosticArray) -> None:
        now = time.monotonic()
        with self._lock:
            for status in message.status:
                level = Level(status.level) if status.level in set(Level) else Level.STALE
                values = tuple((entry.key, entry.value) for entry in status.values)
                self._heard[status.name] = now, Entry(status.name, level, status.message, 0.0, values)

    def entries(self) -> list[Entry]:
        """In the order in which they came first."""
        now = time.monotonic()
        with self._lock:
            return [Entry(e.name, e.level, e.text, now - at, e.values) for at, e in self._heard.values()]


def listen(name: str, seconds: float) -> list[Entry]:
    """A node of this name for so long [s] once it is connected, on the computer's clock: ROS time may stand."""
    rospy.init_node(name, anonymous=True, disable_signals=True)
    ear = Ear()
    ear.wait_for_publishers()
    time.sleep(seconds)
    return ear.entries()
