"""The doctor's drive on a running system: by requests through the safety gate, which may end it at any time."""

from __future__ import annotations

import threading
import time
from typing import Any

import rospy
from geometry_msgs.msg import TwistStamped

from seater_common.geometry import Chair
from seater_msgs.msg import GateState
from seater_nmpc.ros.conversions import velocity_request
from seater_nmpc.ros.gate import Gate
from seater_nmpc.ros.goal_checks import RefusedError
from seater_tools.doctor.gather.drive import STAND, Piece, Stepper
from seater_tools.doctor.gather.legs import make_move
from seater_tools.doctor.observations import Live, Move
from seater_tools.ros.doctor import SystemWatch, wait

PERIOD = 0.05  # [s] of requests
ZEROS = 10  # requests of zero at the end
CONNECT = 2.0  # [s] for the gate to listen


class Mover:
    """One drive. `run` ends with zero requests, whatever happens."""

    def __init__(self, watch: SystemWatch, chair: Chair, plan: list[Piece]) -> None:
        self._watch, self._chair, self._plan = watch, chair, plan
        self._lock, self._stepper = threading.Lock(), Stepper(plan, chair.limits, PERIOD)
        self._out = rospy.Publisher("velocity_request", TwistStamped, queue_size=10, tcp_nodelay=True)
        self._refused = ""
        self._gate: Gate | None = None  # its messages may come before it is here
        self._gate = Gate(self._on_gate, lock_step=False)
        rospy.on_shutdown(self._on_shutdown)

    def run(self, live: Live) -> Move:
        """`live`: what was watched before. A gate that refuses makes a drive that ended at once."""
        begin = self._begin()
        watch, camera = self._watch, live.pictures.info
        watch.on_odometry = self._on_odometry
        try:
            self._drive()
        finally:
            self._rest()
        rows, sights = watch.watcher.since(begin)
        if self._refused:
            return Move((), refused=self._refused)
        if camera is None:  # then nothing is measured in images
            return Move((), None, self._stepper.stopped or "no camera_info arrives")
        return make_move(self._plan, self._stepper, rows, sights, self._chair, camera)

    def _begin(self) -> float:
        """Stamp of the newest odometry [s]: what comes later belongs to the drive."""
        rows, _ = self._watch.watcher.since(-float("inf"))
        return float(rows[-1, 0]) if len(rows) else 0.0

    def _drive(self) -> None:
        assert self._gate is not None
        end = time.monotonic() + CONNECT
        while self._out.get_num_connections() == 0 and time.monotonic() < end:
            wait(PERIOD)
        try:
            self._gate.arm()
        except RefusedError as refused:
            self._refused = refused.text
            return
        wait(2.0 * PERIOD)  # the first odometry for the stepper
        while not self._stepper.over and not rospy.is_shutdown():
            silent = self._gate.silence()
            if silent is not None:
                self._stop(silent.text)
            with self._lock:
                command = self._stepper.command(time.monotonic())
            self._send(*command)
            wait(PERIOD)

    def _rest(self) -> None:
        """Zero for half a second, then stand until odometry and images of it have arrived."""
        self._stop("the doctor ends")
        for _ in range(ZEROS):
            self._send(0.0, 0.0)
            wait(PERIOD)
        if self._gate is not None:
            self._gate.release()
        wait(max(0.0, STAND + 0.5 - ZEROS * PERIOD))

    def _on_odometry(self, stamp: float, pose: Any) -> None:
        with self._lock:
            self._stepper.odometry(stamp, pose, time.monotonic())

    def _on_gate(self, _: str, message: GateState) -> None:
        loss = self._gate.on_state(message) if self._gate is not None else None
        if loss is not None:
            self._stop(loss.text)

    def _stop(self, why: str) -> None:
        with self._lock:
            self._stepper.stop(why)

    def _send(self, v: float, omega: float) -> None:
        self._out.publish(velocity_request(rospy.Time.now(), "base_link", v, omega))

    def _on_shutdown(self) -> None:
        self._stop("the doctor ends")
        self._send(0.0, 0.0)
