"""The docking node without a ROS master: every message goes through its own callbacks, one thread works them off."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import actionlib
import diagnostic_updater
import hostile
import pytest
import rosgraph.masterapi
import rospy
import tf2_ros
import yaml
from actionlib_msgs.msg import GoalStatus

from seater_msgs.srv import GateArmResponse
from seater_nmpc.ros import node as node_module
from seater_nmpc.ros.inbox import worker as worker_module
from seater_nmpc.ros.live import server as live_module
from seater_nmpc.ros.node import DockingNode

CONFIG = Path(__file__).resolve().parents[2] / "config"
FINITE = ("velocity_request", "predicted_path", "dock_pose_filtered", "speed_limit", "/tf", "feedback", "result")


def parameters() -> dict[str, Any]:
    """Those of the node as shipped."""
    files = {"chair": "chair", "dock": "docks/default", "controller": "controller", "camera": "cameras/d455"}
    return {f"~{key}": yaml.safe_load((CONFIG / f"{name}.yaml").read_text()) for key, name in files.items()}


class Stand:
    """Holds the node, delivers messages to it, and checks all that it sends."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **changes: Any) -> None:
        """`changes` of the node's private parameters."""
        self._parameters = parameters() | {f"~{key}": value for key, value in changes.items()}
        self.sent: dict[str, list[Any]] = {}
        self.errors: list[str] = []  # of handlers
        self.violations: list[str] = []
        self.results: list[Any] = []
        self.consent = 0
        self._inputs: dict[str, Callable[[Any], None]] = {}
        self._actions: dict[str, Callable[[Any], None]] = {}
        self.services: dict[str, Callable[[Any], Any]] = {}
        self._replace_ros(monkeypatch)
        self.node = DockingNode()
        self.put, self.work_off = self.node._inbox.put, self.node._inbox.work_off
        self.limits = self.node._core.vehicle.chair.limits

    def arrive(self, topic: str, message: Any, sender: str = "/hostile") -> None:
        """One message, which waits."""
        message._connection_header = {"callerid": sender}  # as rospy does
        self._inputs[topic](message)

    def deliver(self, topic: str, message: Any, sender: str = "/hostile") -> None:
        """One message, worked off at once."""
        self.arrive(topic, message, sender)
        self.work_off()

    def call(self, service: str) -> Any:
        """The answer of a service without arguments. The worker gets its turn whenever it is asked."""
        answers: list[Any] = []
        caller = threading.Thread(target=lambda: answers.append(self.services[service](None)))
        caller.start()
        while caller.is_alive():
            self.work_off()
            caller.join(0.001)
        return answers[0]

    def give(self, kind: str, goal: Any) -> None:
        """A goal of the action `kind`."""
        self._actions[kind](Handle(goal, self))
        self.work_off()

    @property
    def active(self) -> bool:
        return self.node._core.sequence.active

    def publish(self, topic: str, message: Any) -> None:
        """What the node sends: it can be sent, it is finite, and a request keeps the limits."""
        message = hostile.as_received(message)
        self.sent.setdefault(topic, [])[:-10] = []
        self.sent[topic].append(message)
        if topic in FINITE and not all(map(math.isfinite, hostile.numbers(message))):
            self.violations.append(f"{topic} is not finite: {message}")
        if topic == "velocity_request":
            v, omega = message.twist.linear.x, message.twist.angular.z
            if not (-self.limits.v_reverse_max <= v <= self.limits.v_max and abs(omega) <= self.limits.omega_max):
                self.violations.append(f"beyond the limits: {v}, {omega}")

    def _arm(self) -> GateArmResponse:
        self.consent += 1
        return GateArmResponse(granted=True, consent=self.consent)

    def _replace_ros(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def publisher(topic: str, *_: Any, **__: Any) -> Any:
            return SimpleNamespace(publish=lambda message: self.publish(topic, message), unregister=lambda: None)

        def subscriber(topic: str, _: Any, callback: Callable[[Any], None], **__: Any) -> Any:
            self._inputs[topic] = callback
            return SimpleNamespace(unregister=lambda: None)

        def server(kind: str, *_: Any, goal_cb: Callable[[Any], None], **__: Any) -> Any:
            self._actions[kind] = goal_cb
            return SimpleNamespace(start=lambda: None)

        def service(*_: Any) -> Any:
            return Service(self._arm)

        def offered(name: str, _: Any, handler: Callable[[Any], Any]) -> None:
            self.services[name] = handler

        values, silent = self._parameters, lambda *_, **__: None
        rospy.rostime.set_rostime_initialized(True)  # of the wall, where no clock is published
        no_threads = SimpleNamespace(Thread=lambda **_: SimpleNamespace(start=silent))
        broadcaster = SimpleNamespace(sendTransform=lambda message: self.publish("/tf", message))
        replaced = {
            rospy: {
                "Publisher": publisher, "Subscriber": subscriber, "ServiceProxy": service, "Service": offered,
                "on_shutdown": silent, "Timer": silent,
                "get_param": lambda name, default=None: values.get(name, default),
                "resolve_name": lambda name: name, "get_name": lambda: "/docking", "loginfo": silent,
                "has_param": lambda name: name in values,
                "logwarn": silent, "logwarn_throttle": silent,
                "logerr_throttle": lambda _, text, *words: self.errors.append(text % words),
            },
            tf2_ros: {"TransformBroadcaster": lambda: broadcaster},
            rosgraph.masterapi: {"Master": lambda _: SimpleNamespace(lookupService=silent)},
            actionlib: {"ActionServer": server},
            diagnostic_updater: {"Updater": Updater},
            live_module: {"Server": silent},
            node_module: {"threading": no_threads},
            worker_module: {"threading": no_threads},
        }  # fmt: skip
        for module, changes in replaced.items():
            for name, value in changes.items():
                monkeypatch.setattr(module, name, value)


class Service:
    """The gate's service; consent is always given."""

    resolved_name = "/gate_arm"

    def __init__(self, answer: Callable[[], GateArmResponse]) -> None:
        self._answer = answer

    def wait_for_service(self, timeout: float) -> None:
        pass

    def __call__(self, undock: bool) -> GateArmResponse:
        return self._answer()


class Updater:
    """No diagnostics by themselves; `update` asks for them."""

    def __init__(self) -> None:
        self._tasks: list[Callable[[Any], Any]] = []

    def setHardwareID(self, name: str) -> None:
        pass

    def add(self, *task: Any) -> None:
        if callable(task[-1]):
            self._tasks.append(task[-1])

    def update(self) -> None:
        for task in self._tasks:
            task(diagnostic_updater.DiagnosticStatusWrapper())


class Handle:
    """A goal as actionlib hands it over."""

    def __init__(self, goal: Any, stand: Stand) -> None:
        self._goal, self._stand = goal, stand
        self.goal = SimpleNamespace(goal=goal, _connection_header={"callerid": "/client"})

    def get_goal(self) -> Any:
        return self._goal

    def get_goal_status(self) -> GoalStatus:
        return GoalStatus(status=GoalStatus.PENDING)

    def set_accepted(self) -> None:
        pass

    def publish_feedback(self, feedback: Any) -> None:
        self._stand.publish("feedback", feedback)

    def _end(self, result: Any, text: str) -> None:
        self._stand.publish("result", result)
        self._stand.results.append(result)

    set_canceled = set_succeeded = set_aborted = set_rejected = _end
