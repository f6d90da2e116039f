"""The simulated chair on the clock on the wall: obeys cmd_vel and motor_enable, publishes odometry, contact, truth."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper, Updater
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool

from seater_sim.faults.plant import OdometryFault, PlantFault
from seater_sim.loop.motor_enable import MotorEnable
from seater_sim.loop.simulator import Due, Simulator
from seater_sim.ros.chair_topics import ChairTopics, RangeTopics
from seater_sim.ros.fault_service import offer_faults
from seater_sim.ros.free_clock import WallClock
from seater_sim.ros.options import FreeOptions
from seater_sim.ros.program import run_free
from seater_sim.settings import NANOSECONDS, NO_SENSOR, to_ns

_LATE = 0.1  # [s] behind the clock, from which on the run says nothing about a chair
_REPORT = 10.0  # [s] between two lines about it


class PlantNode:
    """Steps the simulator, without its camera, whenever a step's time has come."""

    def __init__(self, options: FreeOptions) -> None:
        self._clock = WallClock()
        settings = replace(options.simulator, start_time=self._clock.now_ns / NANOSECONDS)
        self._simulator = Simulator(
            settings, options.chair, options.dock, None, options.start.as_array(), seed=options.seed
        )
        self._step_ns = to_ns(settings.step)
        self._plant_fault = PlantFault(settings.plant.wheelchair.wheels.track)
        self._odometry_fault = OdometryFault()
        self._relay = MotorEnable(watch_silence=True)
        self._lock = threading.Lock()
        self._command = (0.0, 0.0)  # the last one
        self._behind = 0.0  # [s] the furthest since the last report
        self._contact: bool | None = None
        self._collisions = -1
        self._topics = ChairTopics(settings.obstacles if options.publish_obstacles else [])
        self._topics.publish_obstacles(self._simulator.time_ns)
        kind = settings.ranging.kind
        self._ranges = None if kind == NO_SENSOR else RangeTopics(kind)
        self._topics.publish_static(None, self._simulator.range_sensor, self._simulator.time_ns)
        self._updater = Updater()
        self._updater.setHardwareID("simulated chair")
        self._updater.add("clock", self._diagnose)
        self._subscriber = rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=10, tcp_nodelay=True)
        self._enable = rospy.Subscriber("motor_enable", Bool, self._on_enable, queue_size=10, tcp_nodelay=True)
        self._service = offer_faults(self._fail)

    def _on_command(self, message: Twist) -> None:
        with self._lock:
            if self._plant_fault.kind != "deaf":
                self._command = message.linear.x, message.angular.z
            self._drive()

    def _on_enable(self, message: Bool) -> None:
        with self._lock:
            self._relay.told(message.data, self._simulator.time_ns)

    def _drive(self) -> None:
        self._simulator.command(*self._plant_fault.command(*self._command))

    def _fail(self, component: str, kind: str, values: tuple[float, ...]) -> None:
        with self._lock:
            (self._plant_fault if component == "plant" else self._odometry_fault).set(kind, values)

    def run(self) -> None:
        """Until ROS shuts down."""
        reported = self._simulator.time_ns
        while not rospy.is_shutdown():
            due_ns = self._simulator.time_ns + self._step_ns
            self._clock.sleep_until(due_ns)
            self._behind = max(self._behind, (self._clock.now_ns - due_ns) / NANOSECONDS)
            with self._lock:
                if self._plant_fault.persists:
                    self._drive()
                self._simulator.power(self._relay.on(self._simulator.time_ns))
                due = self._simulator.step()
            self._publish(due)
            self._updater.update()
            if due_ns - reported > to_ns(_REPORT):
                self._report((due_ns - reported) / NANOSECONDS)
                reported, self._behind = due_ns, 0.0

    def _publish(self, due: Due) -> None:
        if due.tick:
            self._topics.publish_truth(due.truth)
        if due.truth.contact != self._contact:
            self._contact = due.truth.contact
            self._topics.publish_contact(self._contact)
        if due.truth.collisions != self._collisions:
            self._collisions = due.truth.collisions
            self._topics.publish_collisions(self._collisions)
        for taken in due.ranges:
            assert self._ranges is not None  # there is a sensor
            self._ranges.publish(taken)
        sample = None if due.odometry is None else self._odometry_fault.apply(due.odometry)
        if sample is not None:
            self._topics.publish_odometry(sample)

    def _report(self, seconds: float) -> None:
        """The real-time factor is 1 as long as the steps keep up; what a loaded machine delays is the messages."""
        if self._behind > _LATE:
            text = "Too slow for the clock on the wall: up to %.2f s behind in the last %.0f s."
            rospy.logwarn(text, self._behind, seconds)

    def _diagnose(self, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        late = self._behind > _LATE
        text = f"up to {self._behind:.2f} s behind the clock on the wall"
        status.summary(DiagnosticStatus.WARN if late else DiagnosticStatus.OK, text)
        return status


def main(argv: Any = None) -> None:
    """Program entry."""
    run_free("plant", PlantNode, argv)
