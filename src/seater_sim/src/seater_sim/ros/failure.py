"""`rosrun seater_sim failure COMPONENT KIND [VALUES]`: a fault in a simulation that runs freely."""

from __future__ import annotations

import argparse
import math
import os
import signal
import socket
import sys
import time
import xmlrpc.client
from pathlib import Path
from typing import Any

import rosgraph
import rospy
from nav_msgs.msg import Odometry

from seater_msgs.srv import Fail
from seater_sim.faults import kinds

SERVICES = {"plant": "plant/fail", "odometry": "plant/fail", "camera": "camera/fail"}
SIGNALS = {"kill": signal.SIGKILL, "end": signal.SIGTERM, "stop": signal.SIGSTOP, "continue": signal.SIGCONT}
_WAIT = 5.0  # [s] for a service that should be there
_ANSWER = 2.0  # [s] for a node's answer
_NODE = {
    "kill": "SIGKILL: it can do nothing any more",
    "end": "SIGTERM: as roslaunch ends it",
    "stop": "SIGSTOP: it stands still, its connections stay",
    "continue": "SIGCONT: it goes on",
}


class FailureError(Exception):
    """The fault could not be injected; the text says why."""


def fail(component: str, kind: str, values: list[float]) -> None:
    """Begin a fault of plant, odometry or camera, or end it (`clear`). Raises FailureError."""
    try:
        kinds.read(component, kind, values)
    except ValueError as error:
        raise FailureError(str(error)) from None
    try:
        rospy.wait_for_service(SERVICES[component], _WAIT)
        answer = rospy.ServiceProxy(SERVICES[component], Fail)(component, kind, values)
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise FailureError(f"{error}; does sim.launch lock_step:=false run?") from None
    if not answer.success:
        raise FailureError(answer.message)


def signal_node(kind: str, name: str) -> None:
    """Send a signal to the process of a node on this machine. Raises FailureError."""
    os.kill(_pid_asked(name) or _pid_found(name), SIGNALS[kind])


def _pid_asked(name: str) -> int | None:
    """What the node itself says; None when it does not answer, as one that stands still. Raises FailureError."""
    default = socket.getdefaulttimeout()
    socket.setdefaulttimeout(_ANSWER)
    try:
        uri = rosgraph.Master("/failure").lookupNode(rosgraph.names.resolve_name(name, "/failure"))
        answer: Any = xmlrpc.client.ServerProxy(uri).getPid("/failure")
        return int(answer[2])
    except rosgraph.MasterException as error:
        raise FailureError(f"node {name}: {error}") from None
    except (OSError, xmlrpc.client.Error):
        return None
    finally:
        socket.setdefaulttimeout(default)


def _pid_found(name: str) -> int:
    """By the name that roslaunch gave the process, of this master. Raises FailureError."""
    word = f"__name:={name.rsplit('/', 1)[-1]}".encode()
    master = f"ROS_MASTER_URI={rosgraph.get_master_uri()}".rstrip("/").encode()
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            environment = [entry.rstrip(b"/") for entry in (folder / "environ").read_bytes().split(b"\0")]
        except OSError:  # it has ended, or is somebody else's
            continue
        if word in words and master in environment:
            return int(folder.name)
    raise FailureError(f"node {name}: it does not answer, and no process of roslaunch has its name")


def wait_until_nearer(distance: float) -> None:
    """Until base_link is nearer to the docking pose than `distance` [m], which is infinite where one need not wait."""
    while math.isfinite(distance):
        message = rospy.wait_for_message("ground_truth", Odometry)
        position = message.pose.pose.position
        if math.hypot(position.x, position.y) < distance:
            return


def describe() -> str:
    """All faults, one a line."""
    lines = []
    for component, its in kinds.COMPONENTS.items():
        lines += [f"  {component} {' '.join([name, *kind.values])}: {kind.text}" for name, kind in its.items()]
        lines.append(f"  {component} {kinds.CLEAR}: whole again")
    return "\n".join(lines + [f"  node {kind} NAME: {text}" for kind, text in _NODE.items()])


def main(argv: list[str]) -> int:
    """Program entry: 0 done, 1 the fault could not be injected, 2 wrong arguments."""
    parser = argparse.ArgumentParser(prog="failure", description=__doc__, epilog="faults:\n" + describe(),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("component", choices=[*kinds.COMPONENTS, "node"])
    parser.add_argument("kind", help="see below")
    parser.add_argument("values", nargs="*", help="numbers, or the name of the node; negative ones after --")
    parser.add_argument("--nearer", type=float, default=math.inf, metavar="M",
                        help="wait until the chair is nearer to the docking pose [m]")  # fmt: skip
    parser.add_argument("--after", type=float, default=0.0, metavar="S", help="then wait so long [s]")
    parser.add_argument("--for", type=float, default=math.inf, metavar="S", dest="lasts",
                        help="end it again after so long [s] (clear, or continue)")  # fmt: skip
    options = parser.parse_args(rospy.myargv(argv)[1:])
    try:
        if not rosgraph.is_master_online():
            where = f"no ROS master answers at {rosgraph.get_master_uri()}"
            raise FailureError(f"{where}: start sim.launch lock_step:=false first")
        rospy.init_node("failure", anonymous=True, disable_signals=True)
        wait_until_nearer(options.nearer)
        time.sleep(options.after)
        inject(options.component, options.kind, options.values)
        if math.isfinite(options.lasts):
            time.sleep(options.lasts)
            node = options.component == "node"
            inject(options.component, "continue" if node else kinds.CLEAR, options.values if node else [])
    except FailureError as error:
        print(f"failure: {error}", file=sys.stderr)
        return 1
    return 0


def inject(component: str, kind: str, values: list[str]) -> None:
    """What the command line says. Raises FailureError."""
    if component == "node":
        if kind not in SIGNALS or len(values) != 1:
            raise FailureError(f"node takes {', '.join(SIGNALS)} and the name of a node")
        signal_node(kind, values[0])
        return
    try:
        numbers = [float(value) for value in values]
    except ValueError:
        raise FailureError(f"{component} {kind}: {values} are not numbers") from None
    fail(component, kind, numbers)
