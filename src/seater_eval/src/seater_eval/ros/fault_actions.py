"""Carries out what the cases of `fault_table` do to a running system."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import actionlib
import rosnode
import rospy
import tf2_ros
from dynamic_reconfigure.client import Client as Reconfigure
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist, TwistStamped
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from seater_msgs.msg import DockAction, DockGoal
from seater_sim.ros.failure import fail, signal_node

_BEAT = 0.1  # [s] of an emergency stop that repeats itself
_STORM = 2.0  # [s]


def _publish_for(publisher: rospy.Publisher, make: Callable[[], Any], seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        publisher.publish(make())
        time.sleep(0.05)


def _twist(v: float, omega: float = 0.0) -> Twist:
    message = Twist()
    message.linear.x, message.angular.z = v, omega
    return message


def _request(v: float) -> TwistStamped:
    message = TwistStamped(twist=_twist(v))
    message.header.stamp = rospy.Time.now()
    return message


class Actions:
    """Publishers stand from the start, as a joystick's does, so that nothing is lost. `with Actions(...)`."""

    def __init__(self, action: tuple[str, ...]) -> None:
        """`action`: of the case."""
        self._kind, *self._words = action
        self._stop = rospy.Publisher("emergency_stop", Bool, queue_size=1, latch=True)
        self._stop.publish(Bool(False))
        self._joystick = rospy.Publisher("user_cmd_vel", Twist, queue_size=1)
        self._goals = actionlib.ActionClient("dock", DockAction)
        self._others = list(self._start_others()) if self._kind == "second" else []
        self._beats = self._kind == "heartbeat"
        if self._beats:
            threading.Thread(target=self._beat, daemon=True).start()

    def __enter__(self) -> Actions:
        return self

    def __exit__(self, *_: object) -> None:
        self._beats = False
        others, self._others = self._others, []
        for other in others:
            other.communicate()  # its stdin ends

    def begin(self) -> None:
        """Returns when it is over, if it is one that ends by itself."""
        getattr(self, f"_begin_{self._kind}")(*self._words)

    def end(self) -> None:
        """The fault is gone."""
        if self._kind == "fail":
            fail(self._words[0], "clear", [])
        elif self._kind == "heartbeat":
            self._beats = True
            threading.Thread(target=self._beat, daemon=True).start()
        elif self._kind == "second":
            self.__exit__()

    def _begin_fail(self, component: str, kind: str, *values: str) -> None:
        fail(component, kind, list(map(float, values)))

    def _begin_emergency_stop(self, seconds: str) -> None:
        self._stop.publish(Bool(True))
        time.sleep(float(seconds))
        self._stop.publish(Bool(False))

    def _begin_heartbeat(self) -> None:
        self._beats = False

    def _beat(self) -> None:
        while self._beats and not rospy.is_shutdown():
            self._stop.publish(Bool(False))
            time.sleep(_BEAT)

    def _begin_joystick(self, v: str, omega: str, seconds: str) -> None:
        _publish_for(self._joystick, lambda: _twist(float(v), float(omega)), float(seconds))
        _publish_for(self._joystick, lambda: _twist(0.0), 0.5)

    def _begin_stop(self, node: str, seconds: str) -> None:
        signal_node("stop", node)
        time.sleep(float(seconds))
        signal_node("continue", node)

    def _begin_signal(self, kind: str, node: str) -> None:
        signal_node(kind, node)

    def _begin_rosnode_kill(self, node: str) -> None:
        rosnode.kill_nodes([node])

    def _begin_foreign(self, v: str, seconds: str) -> None:
        publisher = rospy.Publisher("velocity_request", TwistStamped, queue_size=1)
        _publish_for(publisher, lambda: _request(float(v)), float(seconds))
        publisher.unregister()

    def _begin_second(self, *_: str) -> None:
        for other in self._others:
            assert other.stdin is not None
            other.stdin.write("\n")
            other.stdin.flush()

    def _start_others(self) -> Iterator[subprocess.Popen[str]]:
        """They stand ready, so that their start is no part of what is measured."""
        for said in self._words[0].split("+"):
            command = [sys.executable, "-m", "seater_eval.ros.second_publisher", said, *self._words[1:]]
            other = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            assert other.stdout is not None
            other.stdout.readline()
            yield other

    def _begin_tf_static(self, parent: str, child: str, x: str) -> None:
        moved = TransformStamped()
        moved.header.stamp, moved.header.frame_id, moved.child_frame_id = rospy.Time.now(), parent, child
        moved.transform.translation.x, moved.transform.rotation.w = float(x), 1.0
        self._tf = tf2_ros.StaticTransformBroadcaster()
        self._tf.sendTransform(moved)

    def _begin_live(self, *words: str) -> None:
        """Refused, perhaps: what holds is the node's own affair."""
        client = Reconfigure("docking/live", timeout=5.0)
        client.update_configuration(dict(zip(words[::2], map(float, words[1::2]), strict=True)))

    def _begin_reload(self) -> None:
        rospy.ServiceProxy("reload_docks", Trigger)()

    def _begin_goal(self, kind: str) -> None:
        """One that cannot be worked on, or many of them and their cancels."""
        goal = DockGoal(use_dock_id=True)
        if kind == "storm":
            end = time.monotonic() + _STORM
            while time.monotonic() < end:
                handle = self._goals.send_goal(goal)
                time.sleep(0.02)
                handle.cancel()
            return
        if kind == "nan_timeout":
            goal.timeout = math.nan
        elif kind == "nan_pose":
            goal.use_dock_id, goal.dock_pose = False, PoseStamped()
            goal.dock_pose.header.frame_id, goal.dock_pose.pose.position.x = "odom", math.nan
        else:
            goal.dock_id = "nowhere"
        self._handle = self._goals.send_goal(goal)
