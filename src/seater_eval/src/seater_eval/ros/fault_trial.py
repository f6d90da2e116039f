"""One fault in one docking: `python3 -m seater_eval.ros.fault_trial CASE PLACE FOLDER` prints its row as JSON.

A process of its own for each: rospy knows one master in its life.
"""

from __future__ import annotations

import contextlib
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
import yaml
from nav_msgs.msg import Odometry
from rospkg import RosPack
from std_msgs.msg import UInt32

from seater_common.messages import names_of
from seater_common.params import read_yaml
from seater_eval.docking.recording import heading_of
from seater_eval.faults.cases import CASES, PLACES, Case
from seater_eval.ros.dock_client import DockClient, DockClientError, wait_until
from seater_eval.ros.fault_actions import Actions
from seater_eval.ros.launch_process import LaunchProcess
from seater_msgs.msg import DockResult
from seater_sim.ros.failure import FailureError

START = {"start_x": -2.3, "start_y": 0.15, "start_heading": -0.1}
LAUNCH = {"require_contact": "true", "history": "none", "installation_memory": "none"}
_PATIENCE = 90.0  # [s] for a docking
_TRIES = 5  # of a new goal
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


def run(case: Case, place: str, launch: LaunchProcess) -> dict[str, Any]:
    """The row of one trial. Raises DockClientError when the system did not start."""
    client = DockClient(launch.running)
    client.connect(60.0)
    watch = Watch()
    with Actions(case.action) as actions:
        wait_until(lambda: bool(watch.truth), "the simulated chair", launch.running, 30.0)
        if case.before:
            actions.begin()
        time.sleep(1.0)
        client.send()
        reached = _until(lambda: watch.distance < PLACES[place] or client.done(), launch)
        if not reached or client.done():
            raise DockClientError(f"the chair did not come to {PLACES[place]} m: {client.result()}")
        began = time.monotonic()
        if not case.before:
            actions.begin()
        ended = _until(client.done, launch)
        row: dict[str, Any] = {"fault": case.name, "place": place, **_outcome(client, ended)}
        row |= _measured(watch, began)
        if case.recovers and row["result"] != "SUCCESS":
            actions.end()
            time.sleep(1.0)
            _send_anew(client)
            row["again"] = _outcome(client, _until(client.done, launch))["result"]
    return row


def _send_anew(client: DockClient) -> None:
    """A goal, again and again: a node that was ended is being started anew. Raises DockClientError: nobody answers."""
    for _ in range(_TRIES):
        with contextlib.suppress(DockClientError):
            return client.send(5.0)
    return client.send()


def _measured(watch: Watch, began: float) -> dict[str, Any]:
    """By the truth, after some seconds in which the chair must not move."""
    over = time.monotonic()
    time.sleep(_AFTERWARDS)
    x, y, heading = watch.truth[-1][1:4]
    return {
        "rest_s": watch.rest_after(began),
        "way_m": watch.way(began),
        "moved_afterwards_m": watch.way(over + 1.0),
        "collisions": watch.collisions,
        "position_error_m": math.hypot(x, y),
        "heading_error_deg": math.degrees(math.remainder(heading, 2.0 * math.pi)),
    }


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
    code = NAMES.get(result.result_code, str(result.result_code))
    sds = {"position_sd_m": result.position_sd, "heading_sd_deg": math.degrees(result.heading_sd)}
    return {"result": code, "text": result.result_text, **sds}


NAMES = names_of(DockResult)  # of the result codes


def _end_in_order(number: int, frame: FrameType | None) -> None:
    """SIGTERM: once, and what was launched is ended on the way out."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise SystemExit(1)


def _safety(case: Case, log: Path) -> dict[str, str]:
    """The launch argument for a safety.yaml with the case's values in it; none where it has none."""
    if not case.safety:
        return {}
    values = read_yaml(Path(RosPack().get_path("seater_config"), "safety.yaml"))
    values |= {name: float(value) for name, value in (word.split("=", 1) for word in case.safety)}
    file = log.with_suffix(".safety.yaml")
    file.write_text(yaml.safe_dump(values))
    return {"safety_file": str(file.resolve())}


def main(arguments: list[str]) -> int:
    """Program entry."""
    signal.signal(signal.SIGTERM, _end_in_order)
    number, place, folder = int(arguments[0]), arguments[1], Path(arguments[2])
    case = CASES[number]
    log = folder / f"fault_{number}_{place}"
    chair = LaunchProcess("seater_bringup", "simulated_chair.launch", START, log.with_suffix(".chair.log"))
    # The chair lives on when what people launch has ended.
    system = LaunchProcess(
        "seater_bringup",
        "wheelchair.launch",
        {**LAUNCH, **dict(word.split("=", 1) for word in case.launch), **_safety(case, log)},
        log.with_suffix(".log"),
        chair.port,
    )
    with chair, system:
        os.environ.update(ROS_MASTER_URI=chair.master_uri, ROS_HOSTNAME="localhost")
        try:
            row = run(case, place, system)
        except (DockClientError, FailureError) as error:
            row = {"fault": case.name, "place": place, "result": "NOT RUN", "text": str(error)}
    print(json.dumps(row))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
