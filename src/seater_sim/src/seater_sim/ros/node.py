"""The simulator's node: docs/reference/interfaces.md says what it publishes, obeys and waits for."""

from __future__ import annotations

import threading
import time
from typing import Any

import cv2
import rospy

from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.motor_enable import MotorEnable
from seater_sim.loop.simulator import Due, SimulatedImage, Simulator
from seater_sim.ros.links import Links
from seater_sim.ros.options import Options, load_options
from seater_sim.ros.program import run_node
from seater_sim.settings import NANOSECONDS

PAUSED_PERIOD = 0.1  # [s] wall time between two clock messages while the time stands


class SimNode:
    """Runs the simulator step by step in the calling thread; ROS callbacks only store what arrives."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._simulator = Simulator(
            options.simulator,
            options.chair,
            options.dock,
            options.camera,
            options.start.as_array(),
            seed=options.seed,
            events=options.events,
        )
        self._lock = threading.Lock()
        self._running = threading.Event()
        self._ready = threading.Event()
        self._commands: list[tuple[float, float]] = []
        self._relay = MotorEnable(watch_silence=not options.lock_step)
        self._last_stamped_ns: int | None = None
        self._contact: bool | None = None
        self._collisions = -1
        self._steps = 0
        self._links = Links(options, self)
        if not options.start_paused:
            self._running.set()

    # What arrives ---------------------------------------------------------------------------------------------------

    def on_command(self, v: float, omega: float, stamped: bool) -> None:
        """A velocity command; a plain one is not used while stamped ones arrive."""
        with self._lock:
            now = self._simulator.time_ns
            if stamped:
                self._last_stamped_ns = now
            elif self._last_stamped_ns is not None:
                age = (now - self._last_stamped_ns) / NANOSECONDS
                if age <= self._options.simulator.plant.command_timeout:
                    return
            self._commands.append((v, omega))

    def on_enable(self, enabled: bool) -> None:
        """Power for the motors, or none."""
        with self._lock:
            self._relay.told(enabled, self._simulator.time_ns)

    def on_run(self, run: bool) -> None:
        """Let the time pass, or stand. Answers when everyone is connected and knows where the chair is."""
        while not self._ready.wait(PAUSED_PERIOD) and not rospy.is_shutdown():
            pass
        if run:
            self._running.set()
        else:
            self._running.clear()

    def on_cover(self, cover: bool) -> None:
        """Hide all markers, or show them again."""
        with self._lock:
            self._simulator.world.cover(cover)

    # What goes out --------------------------------------------------------------------------------------------------

    def run(self) -> None:
        """Until ROS shuts down; whatever ends it, the plant stops."""
        try:
            self._loop()
        finally:
            self.close()

    def _loop(self) -> None:
        self._links.publish_static(self._simulator)
        self._publish_contact(self._simulator.truth.contact, self._simulator.truth.collisions)
        self._wait_for_participants()
        self._links.publish_obstacles(self._simulator.time_ns)
        # The state at the start, so that a goal can be given while the time still stands.
        self._links.publish_truth(self._simulator.truth)
        self._send_odometry(self._simulator.first_odometry())
        self._ready.set()
        started, first = time.monotonic(), self._simulator.time_ns
        while not rospy.is_shutdown():
            if not self._running.is_set():
                self._links.publish_clock(self._simulator.time_ns)
                self._running.wait(PAUSED_PERIOD)
                started, first = time.monotonic(), self._simulator.time_ns
                continue
            self._step()
            self._keep_pace(started, first)

    def _wait_for_participants(self) -> None:
        """Before the first step all connections of the lock-step stand, or the first messages would be lost."""
        said = time.monotonic()
        while not rospy.is_shutdown():
            self._links.publish_clock(self._simulator.time_ns)
            missing = self._links.missing() if self._options.lock_step else None
            if missing is None:
                return
            if time.monotonic() - said > 5.0:
                rospy.loginfo("The simulation has not started: %s", missing)
                said = time.monotonic()
            time.sleep(PAUSED_PERIOD)

    def _step(self) -> None:
        with self._lock:
            commands, self._commands = self._commands, []
            if not self._relay.on(self._simulator.time_ns):
                commands = [(0.0, 0.0)]
            for v, omega in commands:
                if not self._simulator.command(v, omega):
                    text = "A velocity command was not finite (%s m/s, %s rad/s); it counts as zero."
                    rospy.logerr_throttle(1.0, text % (v, omega))
            due = self._simulator.step()
        self._steps += 1
        self._links.publish_clock(due.time_ns)
        for event in due.events:
            rospy.loginfo("Event at %.2f s: %s %s", due.time_ns / NANOSECONDS, event.do, list(event.ids) or "")
        self._publish_state(due)
        for image in due.images:
            self._publish_image(image)
        for taken in due.ranges:
            if self._links.publish_range(taken) and self._options.lock_step:
                self._links.wait_for_range_answers(taken.stamp_ns)

    def _publish_state(self, due: Due) -> None:
        if due.tick:
            self._links.publish_truth(due.truth)
        self._publish_contact(due.truth.contact, due.truth.collisions)
        if due.odometry is not None:
            self._send_odometry(due.odometry)

    def _send_odometry(self, sample: OdometrySample) -> None:
        self._links.publish_odometry(sample)
        if self._options.lock_step:
            self._links.wait_for_odometry_answers(sample.time_ns)

    def _publish_image(self, image: SimulatedImage) -> None:
        looked_at = self._links.publish_image(image)
        # Perception is silent about images that are no images, so nobody waits for it then.
        if looked_at and self._options.lock_step and image.encoding != "32FC1" and image.camera_info_valid:
            self._links.wait_for_image_answers(image.stamp_ns)

    def _publish_contact(self, contact: bool, collisions: int) -> None:
        if contact != self._contact:
            self._contact = contact
            self._links.publish_contact(contact)
        if collisions != self._collisions:
            self._collisions = collisions
            self._links.publish_collisions(collisions)

    def _keep_pace(self, started: float, first_ns: int) -> None:
        """At most as fast as ~rate times wall time."""
        if self._options.rate > 0.0:
            ahead = (self._simulator.time_ns - first_ns) / NANOSECONDS / self._options.rate
            left = started + ahead - time.monotonic()
            if left > 0.0:
                time.sleep(left)

    def close(self) -> None:
        """The plant stops; a last line says how it went."""
        self._links.close()
        self._simulator.halt()
        truth = self._simulator.truth
        text = (
            f"simulated {self._steps * self._options.simulator.step:.2f} s, {truth.collisions} collisions, smallest "
            f"clearance {truth.min_clearance:.3f} m, {self._simulator.refused} commands refused, "
            f"{sum(self._links.missed.values())} answers missed {dict(self._links.missed)}"
        )
        print(f"[sim] {text}", flush=True)  # rosout is closed by now


def main(argv: Any = None) -> None:
    """Program entry."""
    rospy.init_node("sim", argv=argv)
    cv2.setNumThreads(1)  # the other core belongs to perception and controller
    if not rospy.get_param("/use_sim_time", False):
        rospy.logwarn("/use_sim_time is not true: other nodes will not follow the simulated time.")
    run_node(lambda: SimNode(load_options()))
