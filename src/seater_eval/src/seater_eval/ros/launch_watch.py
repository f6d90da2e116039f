"""The roslaunch that this node was started by: which nodes beside it have ended, and how to end all in order."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterable
from typing import Any
from xmlrpc.client import Fault, ServerProxy

import rospy

PATIENCE = 10.0  # [s] for roslaunch to end this node


def ended_nodes(names: Iterable[str]) -> list[str]:
    """Those of these nodes (without a namespace) that roslaunch has started and that have ended."""
    alive, dead = _processes(_launch())
    return [name for name in names if name in dead - alive]


def end_launch() -> None:
    """Ends roslaunch as Ctrl-C does, and waits until it ends this node.

    A required node that ends by itself would do so too, but roslaunch would report that in red as a death.
    """
    server = _launch()
    if server is None:
        return
    answer: Any = server.get_pid()
    os.kill(int(answer[2]), signal.SIGINT)
    end = time.monotonic() + PATIENCE
    while not rospy.is_shutdown() and time.monotonic() < end:
        time.sleep(0.05)


def _launch() -> ServerProxy | None:
    """The server of our roslaunch: the parent of this process. None: somebody else has started it."""
    for uri in rospy.get_param("/roslaunch/uris", {}).values():
        server = ServerProxy(uri)
        try:
            answer: Any = server.get_pid()
        except (OSError, Fault):  # of a launch that is over
            continue
        if int(answer[2]) == os.getppid():
            return server
    return None


def _processes(server: ServerProxy | None) -> tuple[set[str], set[str]]:
    """Names of the processes that run, and of those that have ended; roslaunch numbers them: docking-3."""
    if server is None:
        return set(), set()
    answer: Any = server.list_processes()
    alive, dead = ({str(entry[0]).rpartition("-")[0] for entry in part} for part in answer[2])
    return alive, dead
