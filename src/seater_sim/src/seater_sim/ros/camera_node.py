"""The simulated camera on the clock on the wall: draws what it sees from where the chair truly is."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import cv2
import numpy as np
import rospy
from nav_msgs.msg import Odometry
from numpy.typing import NDArray

from seater_common.se2 import arc_step
from seater_sim.camera.camera import Camera
from seater_sim.faults.camera import CameraFault
from seater_sim.loop.simulator import SimulatedImage
from seater_sim.ros.fault_service import offer_faults
from seater_sim.ros.free_clock import WallClock
from seater_sim.ros.image_topics import ImageTopics, Pixels
from seater_sim.ros.options import FreeOptions
from seater_sim.ros.program import run_free
from seater_sim.settings import NANOSECONDS, to_ns

_EXTRAPOLATE = 0.1  # [s] longest: an older truth is where the chair stands


class CameraNode:
    """Takes images at the camera's rate; where drawing is slower than that, images are left out, none comes late."""

    def __init__(self, options: FreeOptions) -> None:
        assert options.camera is not None
        self._options, self._model = options, options.camera
        self._settings = options.simulator.camera
        self._clock, self._fault = WallClock(), CameraFault()
        self._camera = self._make_camera()
        self._ids = frozenset(marker.id for marker in options.dock.markers)
        self._truth: Odometry | None = None
        self._held: NDArray[np.float64] | None = None  # the pose from which a frozen picture was taken
        self._taken_ns: int | None = None  # the last image
        self._on_the_way: deque[tuple[int, SimulatedImage, Pixels | None]] = deque()  # (arrival [ns], image, pixels)
        self._topics = ImageTopics()
        self._subscriber = rospy.Subscriber("ground_truth", Odometry, self._on_truth, queue_size=1, tcp_nodelay=True)
        self._service = offer_faults(self._fail)

    def _make_camera(self) -> Camera:
        o = self._options
        lens, mount = self._fault.lens(self._model), self._fault.mount(o.chair.camera)
        return Camera(lens, mount, o.dock, self._settings, o.simulator.scene, o.simulator.obstacles)

    def _on_truth(self, message: Odometry) -> None:
        self._truth = message

    def _fail(self, component: str, kind: str, values: tuple[float, ...]) -> None:
        self._fault.set(kind, values)
        self._held = None
        self._camera = self._make_camera()

    def run(self) -> None:
        """Until ROS shuts down."""
        period, index, left_out = round(NANOSECONDS / self._settings.rate), 0, 0
        next_ns = self._clock.now_ns + period
        while not rospy.is_shutdown():
            self._clock.sleep_until(min([next_ns, *(due_ns for due_ns, _, _ in self._on_the_way)]))
            self._deliver()
            now_ns = self._clock.now_ns
            if now_ns < next_ns:
                continue
            if now_ns < next_ns + period:
                index += 1
                self._take(index, next_ns)
            else:
                left_out += 1
                rospy.logwarn_throttle(10.0, f"Drawing is too slow: {left_out} images were left out so far.")
            next_ns += period

    def _take(self, index: int, stamp_ns: int) -> None:
        """Draw the image whose exposure has its middle at the stamp."""
        early = self._taken_ns is not None and stamp_ns - self._taken_ns < to_ns(self._fault.period)
        if self._truth is None or self._fault.off or early:
            return
        self._taken_ns = stamp_ns
        pose, v, omega = self._pose_at(self._truth, stamp_ns)
        if self._fault.frozen:
            self._held = pose if self._held is None else self._held
            pose, v, omega, index = self._held, 0.0, 0.0, 1
        image = SimulatedImage(
            index,
            stamp_ns,
            self._fault.seen_from(pose),
            v,
            omega,
            self._ids if self._fault.covered else frozenset(),
            self._fault.mode,
            self._options.seed,
            self._camera,
        )
        due_ns = stamp_ns + to_ns(self._settings.latency + self._fault.delay)
        pixels = image.render() if self._topics.wanted else None
        self._on_the_way.append((due_ns, image, np.zeros_like(pixels) if self._fault.black else pixels))

    def _deliver(self) -> None:
        """Hand over what the camera's latency has been waited for."""
        while self._on_the_way and self._on_the_way[0][0] <= self._clock.now_ns:
            _, image, pixels = self._on_the_way.popleft()
            self._topics.send(image, pixels, self._fault.told(self._model))

    def _pose_at(self, truth: Odometry, stamp_ns: int) -> tuple[NDArray[np.float64], float, float]:
        """Where the chair truly is (3,), and its speeds, from the last truth that came."""
        p, q, twist = truth.pose.pose.position, truth.pose.pose.orientation, truth.twist.twist
        pose = np.array([p.x, p.y, 2.0 * math.atan2(q.z, q.w)])
        v, omega = twist.linear.x, twist.angular.z
        ahead = (stamp_ns - truth.header.stamp.to_nsec()) / NANOSECONDS
        if abs(ahead) > _EXTRAPOLATE:
            return pose, 0.0, 0.0
        return arc_step(pose, v, omega, ahead), v, omega


def main(argv: Any = None) -> None:
    """Program entry."""
    cv2.setNumThreads(1)  # the other cores belong to perception and controller
    run_free("camera", CameraNode, argv)
