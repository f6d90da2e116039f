"""A second publisher of topics: `python3 -m seater_eval.ros.second_publisher SAYS TOPIC...`, ready at a line on stdin.

SAYS: "repeat", what it hears of others; "box" or "nothing", ten times a second on a topic of obstacles.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import rospy
import rostopic
from geometry_msgs.msg import Point32, Polygon

from seater_msgs.msg import ObstacleArray

_PERIOD = 0.1  # [s]
# [m] in odom, aside of every way to the dock
_BOX = ((0.0, 4.0), (0.5, 4.0), (0.5, 4.5), (0.0, 4.5))


def _repeat(topic: str) -> Any:
    """Hears the others from now on; returns what begins to send."""
    kind, _, _ = rostopic.get_topic_class(rospy.resolve_name(topic), blocking=True)
    publishers: list[rospy.Publisher] = []
    last = [0.0]

    def take(message: Any) -> None:
        own = message._connection_header["callerid"] == rospy.get_name()
        if publishers and not own and time.monotonic() - last[0] >= _PERIOD:
            last[0] = time.monotonic()
            publishers[0].publish(message)

    rospy.Subscriber(topic, kind, take, queue_size=1, buff_size=2**24)
    return lambda: publishers.append(rospy.Publisher(topic, kind, queue_size=1))


def _tell(topic: str, says: str) -> Any:
    def begin() -> None:
        publisher = rospy.Publisher(topic, ObstacleArray, queue_size=1)
        polygons = [Polygon([Point32(x, y, 0.0) for x, y in _BOX])] if says == "box" else []

        def send(_: Any) -> None:
            message = ObstacleArray(polygons=polygons)
            message.header.stamp, message.header.frame_id = rospy.Time.now(), "odom"
            publisher.publish(message)

        timers.append(rospy.Timer(rospy.Duration(_PERIOD), send))

    timers: list[rospy.Timer] = []
    return begin


def main(arguments: list[str]) -> int:
    """Program entry; ends with its stdin."""
    says, topics = arguments[0], arguments[1:]
    rospy.init_node("second_publisher", anonymous=True, disable_signals=True)
    begins = [_repeat(topic) if says == "repeat" else _tell(topic, says) for topic in topics]
    print("ready", flush=True)
    if not sys.stdin.readline():
        return 0
    for begin in begins:
        begin()
    sys.stdin.read()
    rospy.signal_shutdown("in order, so that the master lists it no more")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
