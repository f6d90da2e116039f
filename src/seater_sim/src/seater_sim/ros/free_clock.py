"""The clock on the wall, for nodes that run freely."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, TypeVar

import rospy

from seater_common.params import ParameterError
from seater_msgs.srv import Fail, FailRequest, FailResponse
from seater_sim.faults import kinds
from seater_sim.ros.options import FreeOptions, load_free_options

Node = TypeVar("Node")


class WallClock:
    """ROS time that goes on evenly, whatever happens to the system's clock."""

    def __init__(self) -> None:
        self._offset_ns = time.time_ns() - time.monotonic_ns()

    @property
    def now_ns(self) -> int:
        """Nanoseconds since 1970."""
        return time.monotonic_ns() + self._offset_ns

    def sleep_until(self, time_ns: int) -> None:
        """Returns at once when it is past."""
        left = time_ns - self.now_ns
        if left > 0:
            time.sleep(1e-9 * left)


def offer_faults(set_fault: Callable[[str, str, tuple[float, ...]], None]) -> rospy.Service:
    """The service ~fail: begins or ends a fault by `set_fault(component, kind, values)`."""

    def fail(request: FailRequest) -> FailResponse:
        try:
            values = kinds.read(request.component, request.kind, request.values)
        except ValueError as error:
            return FailResponse(success=False, message=str(error))
        set_fault(request.component, request.kind, values)
        rospy.logwarn("Fault: %s %s %s", request.component, request.kind, list(values) or "")
        return FailResponse(success=True, message="")

    return rospy.Service("~fail", Fail, fail)


def run_free(name: str, make: Callable[[FreeOptions], Any], argv: Any = None) -> None:
    """Makes a node of its parameters and runs it until ROS shuts down; ends with 1 where they are wrong."""
    rospy.init_node(name, argv=argv)
    if rospy.get_param("/use_sim_time", False):
        rospy.logfatal(
            "/use_sim_time is true, but this node lives by the clock on the wall (sim.launch lock_step:=false)."
        )
        sys.exit(1)
    try:
        node = make(load_free_options())
    except (ParameterError, ValueError) as error:
        rospy.logfatal("%s: %s", rospy.get_name(), error)
        sys.exit(1)
    try:
        node.run()
    except rospy.ROSException:  # a publisher was closed under our hands: shutdown
        if not rospy.is_shutdown():
            raise
