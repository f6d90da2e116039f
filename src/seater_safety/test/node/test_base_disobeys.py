"""A base that does not do what the gate says; before test_gate_node.py, whose last test ends the master."""

from __future__ import annotations

import subprocess
import threading
import time
from collections.abc import Iterator

import pytest
import rospy
from driver import Driver, wait_until
from nav_msgs.msg import Odometry

from seater_msgs.msg import GateState, MotorFault

SLACK = 0.3  # [s] for a loaded machine


class Base:
    """Odometry at 50 Hz: obeys at once, or moves at `runaway` [m/s] while the motors have power."""

    def __init__(self, driver: Driver) -> None:
        self.runaway: float | None = None
        self._driver, self._ended = driver, threading.Event()
        self._publisher = rospy.Publisher("odom", Odometry, queue_size=1, tcp_nodelay=True)
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def _work(self) -> None:
        while not self._ended.wait(0.02):
            powered = bool(self._driver.enabled) and self._driver.enabled[-1][1]
            speed = self._driver.speed if self.runaway is None else self.runaway
            message = Odometry()
            message.twist.twist.linear.x = speed if powered else 0.0
            self._publisher.publish(message)

    def end(self) -> None:
        """The gate is without odometry then."""
        self._ended.set()
        self._thread.join()
        self._publisher.unregister()


@pytest.fixture
def base(driver: Driver, own_gate: subprocess.Popen[str]) -> Iterator[Base]:
    """Connected to a gate of its own."""
    base = Base(driver)
    wait_until(lambda: base._publisher.get_num_connections() > 0, "the gate to listen to the odometry")
    yield base
    base.end()


def test_motors_that_do_not_obey_lose_their_power(driver: Driver, base: Base) -> None:
    """At once, and until a new goal, which finds a base that obeys again."""
    driver.drive()
    time.sleep(1.0)
    assert driver.enabled[-1][1] and driver.state.state == GateState.REQUEST
    base.runaway = 0.6
    wait_until(lambda: not driver.enabled[-1][1], "the power to be cut", 0.15 + SLACK)
    driver.expect_stop(0.05)
    assert driver.state.state == GateState.RUNAWAY and "drives at 0.60 m/s" in driver.state.reason
    refusal = driver.arm()
    assert not refusal.granted and refusal.state == GateState.RUNAWAY
    driver.velocity = None
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the fault to end", 1.0 + SLACK)
    cut = len(driver.enabled)
    time.sleep(0.5)
    assert not any(enabled for _, enabled in driver.enabled[cut:]), "it would run away again"
    assert driver.state.stopped_by == GateState.RUNAWAY
    base.runaway = None
    driver.drive()
    assert driver.enabled[-1][1]


def test_who_notices_it_may_tell_the_gate(driver: Driver, base: Base) -> None:
    """A docking node that knows the chair's delay notices some of it earlier."""
    publisher = rospy.Publisher("motor_fault", MotorFault, queue_size=1, tcp_nodelay=True)
    wait_until(lambda: publisher.get_num_connections() > 0, "the gate to listen")
    driver.drive()
    publisher.publish(MotorFault(state=GateState.WRONG_DIRECTION, reason="told"))
    wait_until(lambda: not driver.enabled[-1][1], "the power to be cut", SLACK)
    driver.expect_stop(0.05)
    assert (driver.state.state, driver.state.stop_reason) == (GateState.WRONG_DIRECTION, "told")
    driver.velocity = None
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the fault to end", 1.0 + SLACK)
    publisher.unregister()
