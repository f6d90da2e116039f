"""A ROS master of its own, on a free port, and one node in this process: the last test ends the master."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator

import pytest

from own_master import own_master  # isort: skip  # before rospy
from driver import Driver, end_gates, start_gate, wait_until

from seater_msgs.msg import GateState


@pytest.fixture(scope="session")
def master() -> Iterator[subprocess.Popen[bytes]]:
    with own_master() as process:
        yield process


@pytest.fixture(scope="session")
def driver(master: subprocess.Popen[bytes]) -> Driver:
    return Driver()


@pytest.fixture(scope="module")
def shared_gate(driver: Driver) -> list[subprocess.Popen[str]]:
    """The gate of the tests that leave it as it was, if it runs."""
    return []


@pytest.fixture
def gate(driver: Driver, shared_gate: list[subprocess.Popen[str]]) -> subprocess.Popen[str]:
    """A gate as shipped, which the driver hears; standing at the beginning, without a stop."""
    if not shared_gate:
        shared_gate.append(start_gate())
    driver.velocity = None
    driver.connect()
    driver.press(False)
    wait_until(lambda: driver.state.state == GateState.STOPPED and driver.speed == 0.0, "the gate to stand")
    return shared_gate[0]


@pytest.fixture
def own_gate(driver: Driver, shared_gate: list[subprocess.Popen[str]]) -> Iterator[subprocess.Popen[str]]:
    """The same for a test that ends it."""
    end_gates()
    shared_gate.clear()
    process = start_gate()
    driver.connect()
    yield process
    driver.velocity, driver.heartbeat = None, False
    end_gates()
    wait_until(lambda: driver.silence > 0.1, "the gate to be gone")
