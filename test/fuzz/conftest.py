"""A ROS master of its own on a free port for the tests with the gate's node, and that node's surroundings."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src" / "seater_safety" / "test" / "node"))
# Before rospy is imported: it reads the address once.
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    PORT = free.getsockname()[1]
os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{PORT}"
os.environ["ROS_IP"] = "127.0.0.1"

import rosgraph
import rospy
from driver import Driver, end_gates, wait_until


@pytest.fixture(scope="session")
def driver() -> Iterator[Driver]:
    """A node in this process that drives the gate; the master ends with it."""
    process = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)], stdout=subprocess.DEVNULL)
    try:
        wait_until(rosgraph.is_master_online, "the master")
        rospy.init_node("docking", disable_signals=True)
        yield Driver()
    finally:
        end_gates()
        process.kill()
        process.wait()
