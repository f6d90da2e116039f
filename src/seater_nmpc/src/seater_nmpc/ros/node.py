"""The docking node: topics and actions round the ROS-free core. One queue, one worker thread."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable
from typing import Any

import rospy
import tf2_ros
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import Odometry as OdometryMsg
from nav_msgs.msg import Path
from std_msgs.msg import Bool, Header

from seater_common.geometry import Chair, Dock
from seater_common.params import load
from seater_msgs.msg import ControllerStatus, DockInnovation, InputDone, MarkerDetectionArray, ObstacleArray
from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.ros import conversions
from seater_nmpc.ros.diagnostics import Diagnostics
from seater_nmpc.ros.goal_checks import RefusedError, check_goal
from seater_nmpc.ros.goals import Goals
from seater_nmpc.ros.obstacles import Obstacles
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.results import ResultCode, Step
from seater_nmpc.sequence.shadow import Shadow
from seater_nmpc.sequence.vehicle import Vehicle

ZEROS_AFTER_GOAL = 5  # cycles in which zero is repeated after the end of a goal
TIME_JUMP = 1.0  # [s] odometry this much older than the last one means that time started anew


class DockingNode:
    """Private parameters: ~chair, ~dock, ~controller (the files in config/), ~lock_step, ~shadow, ~require_contact,
    ~dock_frame (name of the dock's frame in TF). Topics: docs/architecture.md."""

    def __init__(self) -> None:
        chair = load(Chair, rospy.get_param("~chair", None), rospy.resolve_name("~chair"))
        self._dock = load(Dock, rospy.get_param("~dock", None), rospy.resolve_name("~dock"))
        self._vehicle = Vehicle(chair, self._dock)
        chair = self._vehicle.chair  # from here on it docks forward
        self._parameters = load(NmpcParameters, rospy.get_param("~controller", None), rospy.resolve_name("~controller"))
        self._lock_step = _flag("~lock_step")
        shadow = _flag("~shadow")
        self._dock_frame = rospy.get_param("~dock_frame", "dock")
        control = self._parameters.control
        self._controller = DockingController(chair, self._dock, control, deterministic=self._lock_step)
        self._observer = DockObserver(chair.camera, self._parameters.observer, standing=not shadow)
        navigator = Navigator(chair, self._dock, control, self._parameters.planner)
        self._sequence = DockingSequence(
            chair,
            self._dock,
            self._controller,
            self._observer,
            self._parameters.sequence,
            require_contact=_flag("~require_contact"),
            navigator=navigator,
        )
        self._shadow: Shadow | None = None
        if shadow:
            self._shadow = Shadow(self._controller, self._observer, self._parameters.sequence.max_blind_time)
        self._period = control.control_period
        self._cycle, self._zeros, self._fallbacks_before = -1, 0, 0
        self._stamp, self._odom_frame, self._base_frame = rospy.Time(0), "odom", "base_link"
        self._sending, self._closing = threading.Lock(), False
        self._requested = rospy.Time(0)  # stamp of the last request
        self._contact: bool | None = None
        self._queue: queue.Queue[tuple[str, Any]] = queue.Queue()
        self._clock: Callable[[], float] = rospy.get_time if self._lock_step else time.monotonic
        self._last_odometry = self._clock()
        self._controller.warm_up()  # before anything is advertised: the first cycle is not late
        if not shadow:
            navigator.prepare()
        self._advertise()
        self._obstacles = Obstacles(self._tf, self._dock_frame, self._parameters.sequence.obstacle_timeout)
        self._diagnostics = Diagnostics(self._controller, self._observer, self._period)
        self._goals = Goals(self._enqueue)
        threading.Thread(target=self._work, daemon=True).start()
        threading.Thread(target=self._watch, daemon=True).start()
        rospy.on_shutdown(self._on_shutdown)
        self._subscribe()
        if self._shadow is None:
            self._goals.start()
        rospy.loginfo("docking node ready (%s%s)", control.solver, ", shadow" if shadow else "")

    def _advertise(self) -> None:
        self._request = rospy.Publisher("velocity_request", TwistStamped, queue_size=10)
        self._path = rospy.Publisher("predicted_path", Path, queue_size=10)
        self._filtered = rospy.Publisher("dock_pose_filtered", PoseWithCovarianceStamped, queue_size=10)
        self._innovations = rospy.Publisher("innovations", DockInnovation, queue_size=10)
        self._status = rospy.Publisher("controller_status", ControllerStatus, queue_size=10)
        self._done = rospy.Publisher("input_done", InputDone, queue_size=100) if self._lock_step else None
        self._tf_out = tf2_ros.TransformBroadcaster()
        self._tf = tf2_ros.Buffer()
        self._tf_in = tf2_ros.TransformListener(self._tf)

    def _subscribe(self) -> None:
        """Callbacks only enqueue, so that every input is worked by one thread in the order of its arrival."""
        topics = (
            ("odom", OdometryMsg, 100),
            ("detections", MarkerDetectionArray, 100),
            ("obstacles", ObstacleArray, 10),
        )
        for topic, kind, size in topics:
            rospy.Subscriber(topic, kind, lambda m, t=topic: self._enqueue(t, m), queue_size=size, tcp_nodelay=True)
        rospy.Subscriber("charging_contact", Bool, lambda m: self._enqueue("contact", m.data), queue_size=10)

    def _enqueue(self, kind: str, content: Any) -> None:
        if kind == "odom":
            self._last_odometry = self._clock()
        self._queue.put((kind, content))

    def _work(self) -> None:
        handlers = {
            "odom": self._on_odometry,
            "detections": self._on_detections,
            "obstacles": lambda message: self._obstacles.take(message, self._odom_frame),
            "contact": lambda closed: setattr(self, "_contact", bool(closed)),
            "goal": lambda goal: self._on_goal(*goal),
            "cancel": self._on_cancel,
            "watchdog": lambda _: self._abort(ResultCode.ODOMETRY_LOST, "no odometry arrives"),
        }
        while not rospy.is_shutdown():
            try:
                kind, content = self._queue.get(timeout=0.2)
            except queue.Empty:
                continue
            try:
                handlers[kind](content)
            except rospy.ROSException:  # a publisher was closed by the shutdown
                return
            except Exception as error:  # whatever it is: the chair must stand, and the node must say so
                rospy.logerr_throttle(1.0, "docking node, %s: %s: %s", kind, type(error).__name__, error)
                self._abort(ResultCode.UNKNOWN, f"internal error: {error}")
            self._answer(kind, content)

    def _answer(self, kind: str, content: Any) -> None:
        """In lock-step: this input has been worked through."""
        if self._done is None:
            return
        if kind in ("odom", "detections", "obstacles"):
            requested = kind != "obstacles" and self._requested == content.header.stamp
            self._done.publish(InputDone(content.header, rospy.get_name(), kind, requested))
        elif kind == "contact":
            self._done.publish(InputDone(Header(), rospy.get_name(), "charging_contact", False))

    def _on_odometry(self, message: OdometryMsg) -> None:
        stamp, newest = message.header.stamp.to_sec(), self._observer.odometry.newest
        if newest is not None and stamp < newest.stamp - TIME_JUMP:
            self._abort(ResultCode.ODOMETRY_LOST, "time went backward")
            self._observer.odometry.clear()
            self._observer.reset()
            self._cycle = -1
        if not self._sequence.add_odometry(self._vehicle.odometry(conversions.odometry(message))):
            rospy.logwarn_throttle(1.0, "odometry refused: not finite, or its stamp %.3f is not newer", stamp)
        self._stamp = max(self._stamp, message.header.stamp) if self._cycle >= 0 else message.header.stamp
        self._odom_frame = message.header.frame_id or self._odom_frame
        self._base_frame = message.child_frame_id or self._base_frame
        cycle = math.floor(stamp / self._period + 1e-6)
        if cycle > self._cycle:
            self._cycle = cycle
            self._control(stamp)

    def _control(self, now: float) -> None:
        """One control cycle, at the first odometry in each period of message time."""
        self._diagnostics.cycle()
        self._set_obstacles(now)
        if self._shadow is not None:
            command = self._shadow.update(now)
            self._report(self._vehicle.command(command or Command(v=0.0, omega=0.0)), "SHADOW")
        elif self._sequence.active:
            self._send(self._sequence.update(now, self._contact))
        else:
            if self._zeros > 0:
                self._zeros -= 1
                self._publish_request(0.0, 0.0)
            self._report(Command(v=0.0, omega=0.0), "")

    def _set_obstacles(self, now: float) -> None:
        estimate = self._observer.estimate()
        dock = None if estimate is None else estimate.pose
        self._controller.set_obstacles(self._obstacles.now(now, self._odom_frame, dock))

    def _send(self, step: Step) -> None:
        command = self._vehicle.command(step.command)
        self._publish_request(command.v, command.omega)
        self._report(command, step.phase.name)
        self._goals.publish(step)
        if step.done:
            self._zeros = ZEROS_AFTER_GOAL

    def _report(self, command: Command, phase: str) -> None:
        estimate, counters = self._observer.estimate(), self._controller.counters
        fallbacks = counters.shifted + counters.braked - self._fallbacks_before
        age = -1.0 if estimate is None else estimate.age
        self._status.publish(conversions.status(self._stamp, self._odom_frame, command, phase, fallbacks, age))
        if len(command.path):
            self._path.publish(conversions.path(self._stamp, self._odom_frame, command.path))
        self._diagnostics.report(command, age)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        stamp = message.header.stamp
        fusion = self._sequence.add_detections(stamp.to_sec(), conversions.hypotheses(message))
        if message.dock:
            self._innovations.publish(conversions.innovation(stamp, self._odom_frame, fusion))
        if not fusion.outcome.accepted:
            return
        estimate = self._observer.estimate()
        if estimate is not None:  # with the stamp of the image: a lost marker is silence
            self._filtered.publish(conversions.filtered_pose(stamp, self._odom_frame, estimate))
            self._tf_out.sendTransform(conversions.transform(stamp, self._odom_frame, self._dock_frame, estimate.pose))

    def _on_goal(self, kind: str, handle: Any) -> None:
        goal, now = handle.get_goal(), self._stamp.to_sec()
        if self._goals.active and self._goals.kind != kind:
            return self._goals.refuse(kind, handle, ResultCode.BUSY, f"{self._goals.kind} is active")
        if self._observer.odometry.newest is None:
            return self._goals.refuse(kind, handle, ResultCode.ODOMETRY_LOST, "no odometry yet")
        try:
            prior = check_goal(kind, goal, self._dock.name, self._tf, self._odom_frame)
        except RefusedError as refused:
            return self._goals.refuse(kind, handle, refused.code, refused.text)
        self._abort(ResultCode.CANCELED, "replaced by a new goal")
        self._goals.accept(kind, handle)
        counters = self._controller.counters
        self._fallbacks_before = counters.shifted + counters.braked
        if kind == "dock":
            self._sequence.start_dock(now, goal.timeout, prior)
        else:
            self._sequence.start_undock(now, goal.timeout)

    def _on_cancel(self, handle: Any) -> None:
        if self._goals.is_current(handle):
            self._abort(ResultCode.CANCELED, "cancelled")

    def _abort(self, code: ResultCode, text: str) -> None:
        if self._sequence.active:
            self._send(self._sequence.abort(self._stamp.to_sec(), code, text))

    def _publish_request(self, v: float, omega: float) -> None:
        with self._sending:  # after the shutdown began nothing but zero goes out, whatever the worker is about to send
            v, omega = (0.0, 0.0) if self._closing else (v, omega)
            self._requested = self._stamp
            self._request.publish(conversions.velocity_request(self._stamp, self._base_frame, v, omega))

    def _watch(self) -> None:
        """Zero when the odometry stops during a goal, even when the worker is busy.

        In lock-step the simulator's time counts, which may stand while others are waited for; else wall time.
        """
        limit = self._parameters.sequence.odometry_timeout
        while not rospy.is_shutdown():
            time.sleep(0.05)
            if self._sequence.active and self._clock() - self._last_odometry > limit:
                self._publish_request(0.0, 0.0)
                self._enqueue("watchdog", None)

    def _on_shutdown(self) -> None:
        with self._sending:
            self._closing = True
        for _ in range(3):
            if self._shadow is None:
                self._publish_request(0.0, 0.0)
            time.sleep(0.02)


def _flag(name: str) -> bool:
    value = rospy.get_param(name, False)
    if not isinstance(value, bool):
        raise ValueError(f"{rospy.resolve_name(name)}: is {value!r}, must be true or false")
    return value
