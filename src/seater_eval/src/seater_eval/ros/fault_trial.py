"""One fault in one docking: `python3 -m seater_eval.ros.fault_trial CASE PLACE FOLDER` prints its row as JSON.

A process of its own for each: rospy knows one master in its life.
"""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from types import FrameType
from typing import Any

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool, UInt32

from seater_common.messages import names_of
from seater_eval.docking.recording import heading_of
from seater_eval.faults.cases import CASES, PLACES, Case
from seater_eval.ros.dock_client import DockClient, DockClientError, wait_until
from seater_eval.ros.launch_process import LaunchProcess
from seater_msgs.msg import DockResult
from seater_sim.ros.failure import FailureError, fail, signal_node

START = {"start_x": -2.3, "start_y": 0.15, "start_heading": -0.1}
_PATIENCE = 90.0  # [s] for a docking
_AFTERWARDS = 3.0  # [s] after the end, in which the chair must not move
_STANDS = 0.005  # [m/s, rad/s]


class Watch:
    """Follows the truth."""

    def __init__(self) -> None:
        self.truth: list[tuple[float, ...]] = []  # time of arrival [s], x, y, heading, v, omega
        self.collisions = 0
        rospy.Subscriber("ground_truth", Odometry, self._on_truth, queue_size=1000)
        rospy.Subscriber("collisions", UInt32, self._on_collisions, queue_size=10)

    def _on_truth(self, message: Odometry) -> None:
        p, twist = message.pose.pose, message.twist.twist
        row = (p.position.x, p.position.y, heading_of(p.orientation), twist.linear.x, twist.angular.z)
        self.truth.append((time.monotonic(), *row))

    def _on_collisions(self, message: UInt32) -> None:
        self.collisions = message.data

    @property
    def distance(self) -> float:
        """Of base_link from the docking pose [m]."""
        return math.hypot(*self.truth[-1][1:3]) if self.truth else math.inf

    def rest_after(self, since: float) -> float:
        """From `since` until it stands for good [s]; infinite while it moves."""
        moving = [row[0] for row in self.truth if row[0] >= since and max(abs(row[4]), abs(row[5])) > _STANDS]
        if moving and self.truth[-1][0] - moving[-1] < 0.1:
            return math.inf
        return moving[-1] - since if moving else 0.0

    def way(self, since: float) -> float:
        """Driven since then [m]."""
        rows = [row for row in self.truth if row[0] >= since]
        return sum(math.dist(a[1:3], b[1:3]) for a, b in pairwise(rows))


def _publish_for(publisher: rospy.Publisher, make: Callable[[], Any], seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        publisher.publish(make())
        time.sleep(0.05)


def _twist(v: float, omega: float = 0.0) -> Twist:
    message = Twist()
    message.linear.x, message.angular.z = v, omega
    return message


def _request(v: float) -> TwistStamped:
    message = TwistStamped(twist=_twist(v))
    message.header.stamp = rospy.Time.now()
    return message


class Actions:
    """Carries faults out. Publishers stand from the start, as a joystick's does, so that nothing is lost."""

    def __init__(self) -> None:
        self._stop = rospy.Publisher("emergency_stop", Bool, queue_size=1, latch=True)
        self._stop.publish(Bool(False))
        self._joystick = rospy.Publisher("user_cmd_vel", Twist, queue_size=1)

    def begin(self, action: tuple[str, ...]) -> None:
        """Of a case; returns when it is over, if it is one that ends by itself."""
        kind, *words = action
        if kind == "fail":
            fail(words[0], words[1], list(map(float, words[2:])))
        elif kind == "emergency_stop":
            self._stop.publish(Bool(True))
            time.sleep(float(words[0]))
            self._stop.publish(Bool(False))
        elif kind == "joystick":
            v, omega, seconds = map(float, words)
            _publish_for(self._joystick, lambda: _twist(v, omega), seconds)
            _publish_for(self._joystick, lambda: _twist(0.0), 0.5)
        elif kind == "stop":
            signal_node("stop", words[0])
            time.sleep(float(words[1]))
            signal_node("continue", words[0])
        elif kind == "foreign":
            publisher = rospy.Publisher("velocity_request", TwistStamped, queue_size=1)
            _publish_for(publisher, lambda: _request(float(words[0])), float(words[1]))
            publisher.unregister()
        else:
            signal_node(words[0], words[1])

    def end(self, action: tuple[str, ...]) -> None:
        """The fault is gone."""
        if action[0] == "fail":
            fail(action[1], "clear", [])


def run(case: Case, place: str, launch: LaunchProcess) -> dict[str, Any]:
    """The row of one trial. Raises DockClientError when the system did not start."""
    client = DockClient(launch.running)
    client.connect(60.0)
    watch, actions = Watch(), Actions()
    wait_until(lambda: bool(watch.truth), "the simulated chair", launch.running, 30.0)
    time.sleep(1.0)
    client.send()
    reached = _until(lambda: watch.distance < PLACES[place] or client.done(), launch)
    if not reached or client.done():
        raise DockClientError(f"the chair did not come to {PLACES[place]} m: {client.result()}")
    began = time.monotonic()
    actions.begin(case.action)
    ended = _until(client.done, launch)
    row: dict[str, Any] = {"fault": case.name, "place": place, **_outcome(client, ended)}
    over = time.monotonic()
    time.sleep(_AFTERWARDS)
    x, y, heading = watch.truth[-1][1:4]
    row |= {
        "rest_s": watch.rest_after(began),
        "way_m": watch.way(began),
        "moved_afterwards_m": watch.way(over + 1.0),
        "collisions": watch.collisions,
        "position_error_m": math.hypot(x, y),
        "heading_error_deg": math.degrees(math.remainder(heading, 2.0 * math.pi)),
    }
    if case.recovers and row["result"] != "SUCCESS":
        actions.end(case.action)
        time.sleep(1.0)
        client.send()
        row["again"] = _outcome(client, _until(client.done, launch))["result"]
    return row


def _until(condition: Callable[[], bool], launch: LaunchProcess) -> bool:
    """Whether it came about within the patience, while the system ran."""
    try:
        wait_until(condition, "the docking", launch.running, _PATIENCE)
    except DockClientError:
        return False
    return True


def _outcome(client: DockClient, ended: bool) -> dict[str, Any]:
    result = client.result() if ended else None
    if result is None:
        return {"result": "UNKNOWN", "text": "no result"}
    return {"result": NAMES.get(result.result_code, str(result.result_code)), "text": result.result_text}


NAMES = names_of(DockResult)  # of the result codes


def _end_in_order(number: int, frame: FrameType | None) -> None:
    """SIGTERM: once, and what was launched is ended on the way out."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise SystemExit(1)


def main(arguments: list[str]) -> int:
    """Program entry."""
    signal.signal(signal.SIGTERM, _end_in_order)
    number, place, folder = int(arguments[0]), arguments[1], Path(arguments[2])
    log = folder / f"fault_{number}_{place}"
    chair = LaunchProcess("seater_bringup", "simulated_chair.launch", START, log.with_suffix(".chair.log"))
    # The chair lives on when what people launch has ended.
    system = LaunchProcess(
        "seater_bringup",
        "wheelchair.launch",
        {"require_contact": "true", "history": "none", "installation_memory": "none"},
        log.with_suffix(".log"),
        chair.port,
    )
    with chair, system:
        os.environ.update(ROS_MASTER_URI=chair.master_uri, ROS_HOSTNAME="localhost")
        try:
            row = run(CASES[number], place, system)
        except (DockClientError, FailureError) as error:
            row = {"fault": CASES[number].name, "place": place, "result": "NOT RUN", "text": str(error)}
    print(json.dumps(row))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
