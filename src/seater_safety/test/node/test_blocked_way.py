"""Sensors of obstacles and the gate's node; before test_gate_node.py, whose last test ends the master."""

from __future__ import annotations

import subprocess
import threading
import time
from collections.abc import Iterator

import pytest
import rosgraph
import rospy
from driver import Driver, end_gates, start_gate, wait_until

from seater_msgs.msg import GateState, ObstaclePoints

SLACK = 0.3  # [s] for a loaded machine
BRAKING = 0.15 / 1.5  # [s]
TIMEOUT = 0.5  # [s] obstacle_timeout as shipped
FRONT = 0.75  # [m] of the footprint


class Sensor:
    """Ten measurements per second, of `points` in `frame`, while it is not silent."""

    def __init__(self, topic: str = "obstacle_points", source: str = "scan") -> None:
        self.source = source
        self.points: list[tuple[float, float]] = []
        self.frame, self.silent = "base_link", False
        self._ended = threading.Event()
        self._publisher = rospy.Publisher(topic, ObstaclePoints, queue_size=1, tcp_nodelay=True)
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def _work(self) -> None:
        while not self._ended.wait(0.1):
            if self.silent:
                continue
            message = ObstaclePoints(source=self.source, x=[p[0] for p in self.points], y=[p[1] for p in self.points])
            message.header.stamp, message.header.frame_id = rospy.Time.now(), self.frame
            self._publisher.publish(message)

    def connected(self) -> bool:
        return bool(self._publisher.get_num_connections() > 0)

    def end(self) -> None:
        self._ended.set()
        self._thread.join()
        self._publisher.unregister()


@pytest.fixture
def sensor(driver: Driver, shared_gate: list[subprocess.Popen[str]]) -> Iterator[Sensor]:
    """Connected to a gate that requires it."""
    end_gates()
    shared_gate.clear()
    master = rosgraph.Master("/test")
    master.setParam("/safety_gate/obstacle_sources", "scan")
    start_gate()
    driver.connect()
    sensor = Sensor()
    wait_until(sensor.connected, "the gate to listen to the sensor")
    yield sensor
    driver.velocity = None
    sensor.end()
    end_gates()
    master.deleteParam("/safety_gate/obstacle_sources")
    wait_until(lambda: driver.silence > 0.1, "the gate to be gone")


def test_something_ahead_stops_the_chair_and_it_drives_on_when_that_has_gone(driver: Driver, sensor: Sensor) -> None:
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the gate to stand")
    driver.drive()
    sensor.points = [(FRONT + 0.05, 0.0)]
    driver.expect_stop(0.1 + BRAKING + SLACK)
    assert driver.state.state == GateState.OBSTACLE and driver.state.motion_allowed
    assert "something is in the way" in driver.state.reason
    sensor.points = []
    wait_until(lambda: driver.speed > 0.1, "the chair to drive on", 2.0)


def test_an_unknown_frame_and_silence_end_the_consent(driver: Driver, sensor: Sensor) -> None:
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the gate to stand")
    driver.drive()
    sensor.frame = "/odom"
    driver.expect_stop(0.1 + BRAKING + SLACK)
    assert driver.state.stopped_by == GateState.OBSTACLE and "'/odom'" in driver.state.stop_reason
    sensor.frame = "base_link"
    driver.drive()
    sensor.silent = True
    driver.expect_stop(TIMEOUT + BRAKING + SLACK)
    assert driver.state.stopped_by == GateState.OBSTACLE and "silent" in driver.state.stop_reason
    driver.velocity = (0.0, 0.0)
    answer = driver.arm()
    assert not answer.granted and answer.state == GateState.OBSTACLE and "silent" in answer.reason


def test_the_joystick_stops_at_a_wall_of_the_bay_and_the_way_out_is_open(driver: Driver, sensor: Sensor) -> None:
    """It could be pushed against the wall, again and again."""
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the gate to stand")
    walls = Sensor("bay_walls", "bay")
    wait_until(walls.connected, "the gate to listen to the walls")
    walls.points = [(FRONT + 0.02, 0.0)]  # within the margin
    try:
        for v, moves in ((0.15, False), (-0.15, True)):
            time.sleep(1.0)  # let go meanwhile
            for _ in range(12):
                driver.deflect(v)
                time.sleep(0.05)
            assert (abs(driver.speed) > 0.1) is moves
            assert (driver.state.state == GateState.OBSTACLE) is not moves
    finally:
        walls.end()


def test_a_second_node_that_tells_points_is_a_fault(driver: Driver, sensor: Sensor) -> None:
    """One source is required, so one node: the other one might say that the way is free."""
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the gate to stand")
    driver.drive()
    command = ["rostopic", "pub", "-r", "10", "obstacle_points", "seater_msgs/ObstaclePoints", "{source: scan}"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as other:
        wait_until(lambda: driver.state.state == GateState.FAULT, "the fault")
        assert "2 nodes publish /obstacle_points, one is allowed" in driver.state.reason
        driver.expect_stop(BRAKING + SLACK)
        other.terminate()
