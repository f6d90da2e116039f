"""A ROS master of its own on a free port; import this before rospy, which reads the address once."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    PORT = free.getsockname()[1]
os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{PORT}"
os.environ["ROS_IP"] = "127.0.0.1"

import rosgraph
import rospy
from driver import wait_until


@contextmanager
def own_master() -> Iterator[subprocess.Popen[bytes]]:
    """Its process, and this one as the node `docking`."""
    process = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)], stdout=subprocess.DEVNULL)
    try:
        wait_until(rosgraph.is_master_online, "the master")
        rospy.init_node("docking", disable_signals=True)
        yield process
    finally:
        process.kill()
        process.wait()
