"""How the programs of this package begin and end."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, Protocol

import rospy

from seater_common.params import ParameterError
from seater_sim.ros.options import FreeOptions, load_free_options


class Node(Protocol):
    """What is run."""

    def run(self) -> None:
        """Until ROS shuts down."""


def run_node(make: Callable[[], Node]) -> None:
    """Makes a node and runs it until ROS shuts down; ends with 1 where its parameters are wrong."""
    try:
        node = make()
    except (ParameterError, ValueError) as error:
        rospy.logfatal("%s: %s", rospy.get_name(), error)
        sys.exit(1)
    try:
        node.run()
    except rospy.ROSException:  # a publisher was closed under our hands: shutdown
        if not rospy.is_shutdown():
            raise


def run_free(name: str, make: Callable[[FreeOptions], Node], argv: Any = None) -> None:
    """The same for a node on the clock on the wall, which simulated time would mislead."""
    rospy.init_node(name, argv=argv)
    if rospy.get_param("/use_sim_time", False):
        rospy.logfatal(
            "/use_sim_time is true, but this node lives by the clock on the wall (sim.launch lock_step:=false)."
        )
        sys.exit(1)
    run_node(lambda: make(load_free_options()))
