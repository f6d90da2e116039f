"""Hostile messages to the gate's node: it lives, its output is finite and within limits, and the next goal drives."""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rosgraph
import rospy
import yaml
from amount import EPISODES, PER_EPISODE
from driver import Driver, end_gates, start_gate, wait_until
from geometry_msgs.msg import Twist, TwistStamped
from hostile import Hostile
from nav_msgs.msg import Odometry
from std_msgs.msg import Bool

from seater_msgs.msg import GateState, MotorFault, ObstaclePoints, SpeedLimit

LIMITS = yaml.safe_load((Path(__file__).resolve().parents[2] / "config" / "chair.yaml").read_text())["limits"]
BURST, PAUSE = 5, 0.001  # messages, then [s]: the gate's queues hold 10, and none shall be dropped
STANDS = 1.3  # [s] of odometry of a standing chair, after which a fault of the motors is over


def request() -> TwistStamped:
    message = TwistStamped(twist=twist(0.1))
    message.header.stamp = rospy.Time.now()
    return message


def twist(v: float) -> Twist:
    message = Twist()
    message.linear.x = v
    return message


def points(source: str) -> ObstaclePoints:
    message = ObstaclePoints(source=source, x=[3.0], y=[2.0])
    message.header.frame_id, message.header.stamp = "base_link", rospy.Time.now()
    return message


GOOD: dict[str, Callable[[], Any]] = {
    "velocity_request": request,
    "user_cmd_vel": lambda: twist(0.1),
    "emergency_stop": lambda: Bool(False),
    "hold_to_run": lambda: Bool(True),
    "speed_limit": lambda: SpeedLimit(v_max=0.6),
    "odom": Odometry,
    "motor_fault": lambda: MotorFault(state=GateState.RUNAWAY, reason="told"),
    "obstacle_points": lambda: points("scan"),
    "bay_walls": lambda: points("bay"),
}


@pytest.fixture(scope="module")
def gate(driver: Driver) -> Iterator[subprocess.Popen[str]]:
    """As shipped, standing."""
    process = start_gate()
    driver.connect()
    driver.press(False)
    yield process
    driver.velocity = None
    end_gates()


@pytest.fixture(scope="module")
def publishers() -> dict[str, rospy.Publisher]:
    return {topic: rospy.Publisher(topic, type(good()), queue_size=100) for topic, good in GOOD.items()}


def test_every_input_of_the_gate_is_attacked(gate: subprocess.Popen[str]) -> None:
    """A new input has to be among those above. Its own outputs it only watches for a second gate."""
    subscribed = {topic for topic, nodes in rosgraph.Master("/test").getSystemState()[1] if "/safety_gate" in nodes}
    assert {topic.strip("/") for topic in subscribed} - {"cmd_vel", "gate_state"} == set(GOOD)


@pytest.mark.parametrize("topic", GOOD)
def test_hostile_messages_to_the_gate(
    driver: Driver, gate: subprocess.Popen[str], publishers: dict[str, rospy.Publisher], topic: str
) -> None:
    hostile, publisher = Hostile(topic), publishers[topic]
    wait_until(lambda: publisher.get_num_connections() > 0, "the gate to listen")
    for episode in range(EPISODES):
        driver.drive()
        driver.commands.clear()
        for number in range(PER_EPISODE):
            publisher.publish(hostile.spoil(GOOD[topic]()))
            if number % BURST == 0:
                time.sleep(PAUSE)
        assert gate.poll() is None, f"{topic}, episode {episode}: the gate has died"
        recover(driver, publishers)
        assert [command for command in driver.commands if not permitted(*command[1:])] == []
    driver.drive()
    assert driver.speed == pytest.approx(0.15)


def permitted(v: float, omega: float) -> bool:
    finite = math.isfinite(v) and math.isfinite(omega)
    return finite and -LIMITS["v_reverse_max"] <= v <= LIMITS["v_max"] and abs(omega) <= LIMITS["omega_max"]


def recover(driver: Driver, publishers: dict[str, rospy.Publisher]) -> None:
    """Everybody says what is right again."""
    driver.velocity = (0.0, 0.0)
    driver.press(False)
    driver.deflect(0.0)
    driver.limit_speed(0.6)
    end = time.monotonic() + STANDS
    while driver.state.state in (GateState.RUNAWAY, GateState.WRONG_DIRECTION) or time.monotonic() < end - STANDS + 0.2:
        assert time.monotonic() < end + 1.0, driver.state
        publishers["odom"].publish(Odometry())
        publishers["obstacle_points"].publish(points("scan"))
        time.sleep(0.02)
