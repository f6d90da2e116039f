"""The docking node: topics and actions round the ROS-free core. One queue, one worker thread."""

from __future__ import annotations

import contextlib
import math
import threading
import time
from dataclasses import replace
from typing import Any

import rospy
import tf2_ros
from nav_msgs.msg import Odometry as OdometryMsg
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Bool, Header

from seater_common.files.docks import DockEntry
from seater_msgs.msg import MarkerDetectionArray, ObstacleArray
from seater_nmpc.control.command import Command
from seater_nmpc.observe.observer import DockEstimate
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.ros import conversions
from seater_nmpc.ros.camera import info_topic, usable
from seater_nmpc.ros.core import Core, CoreMaker, flag
from seater_nmpc.ros.diagnostics import Diagnostics
from seater_nmpc.ros.docks.in_use import DockInUse
from seater_nmpc.ros.docks.library import Docks, Loaded, read_docks
from seater_nmpc.ros.docks.services import DockServices
from seater_nmpc.ros.docks.walls import BayWalls
from seater_nmpc.ros.gate import BY_A_PERSON, Gate, Loss
from seater_nmpc.ros.goal_checks import RefusedError, check_goal, dock_of
from seater_nmpc.ros.goals import ClientWatch, Goals
from seater_nmpc.ros.inbox.inputs import Inputs
from seater_nmpc.ros.inbox.odometry_age import OdometryAge
from seater_nmpc.ros.inbox.worker import Handler, Worker
from seater_nmpc.ros.live.server import LiveParameters
from seater_nmpc.ros.obstacles import Obstacles
from seater_nmpc.ros.publishers import Publishers
from seater_nmpc.ros.resume import ResumeService
from seater_nmpc.ros.speed_zone import SpeedZone
from seater_nmpc.ros.transforms import TransformBuffer
from seater_nmpc.sequence.goal.results import Phase, ResultCode, Step

ZEROS_AFTER_GOAL = 5  # cycles in which zero is repeated after the end of a goal, or the beginning of a pause
OUT_OF_DATE = 0.2  # [s] a request that is based on older odometry is not sent: the gate brakes in silence, too
STOOD_STILL = 0.25  # [s] of this process: the gate, which hears of no request for so long, brakes (request_timeout)
TIME_JUMP = 1.0  # [s] odometry this much older than the last one means that time started anew


class DockingNode:
    """Private parameters: ~chair, ~dock, ~controller, ~camera (the files in config/), ~docks (a folder of further dock
    files), ~rectified, ~lock_step, ~shadow, ~require_contact, ~dock_frame (name of the dock's frame in TF). Topics:
    docs/reference/interfaces.md."""

    def __init__(self) -> None:
        lock_step, self._dock_frame = flag("~lock_step"), rospy.get_param("~dock_frame", "dock")
        self._maker = CoreMaker(lock_step=lock_step)
        self._live: LiveParameters | None = None
        docks: Docks[Core] = Docks(read_docks, self._make_core)  # before all is advertised
        core = docks.core()
        self._period = core.parameters.control.control_period
        self._cycle, self._zeros, self._fallbacks_before = -1, 0, 0
        self._contact: bool | None = None
        self._odometry: Odometry | None = None  # the newest that was of use
        self._inbox = Worker(lambda text: self._abort(ResultCode.UNKNOWN, text), self._answer)
        self._age = OdometryAge(lock_step=lock_step)
        self._camera_info = info_topic(rospy.resolve_name("image"))
        names = {topic: rospy.resolve_name(topic) for topic in ("odom", "detections", "obstacles")}
        self._inputs = Inputs(names | {"camera_info": self._camera_info}, usable)
        self._out = Publishers(self._dock_frame, lock_step)
        self._tf = TransformBuffer()
        self._tf_in = tf2_ros.TransformListener(self._tf)
        self._obstacles = Obstacles(self._tf, self._dock_frame, core.parameters.sequence.obstacle_timeout)
        self._diagnostics = Diagnostics(core.controller, core.observer, self._period, self._age.silence)
        self._goals = Goals(self._inbox.put)
        self._client = ClientWatch(core.parameters.sequence.client_timeout)
        self._gate = Gate(self._inbox.put, lock_step=lock_step)
        self._walls = None if lock_step or core.shadow is not None else BayWalls()
        self._zone = SpeedZone(core.chair, core.dock, core.parameters.sequence.back_out_speed)
        self._dock_services = DockServices(docks, self._inbox.ask, speaks=core.shadow is None)
        contact = flag("~require_contact")
        self._in_use = DockInUse(docks, self._dock_services, self._follow, require_contact=contact)
        self._inbox.start(self._handlers())
        threading.Thread(target=self._watch, daemon=True).start()
        rospy.on_shutdown(self._on_shutdown)
        self._subscribe()
        if core.shadow is None:
            self._resume = ResumeService(self._inbox.ask, self._go_on)
            self._dock_services.offer(self._why_not_reload, self._take_docks)
            if core.parameters.control.formulation == "docking":  # the other one has neither these weights nor a cap
                self._live = LiveParameters(docks.cores, self._inbox.ask, lambda: self._core.sequence.active)
            self._goals.start()
        solver = core.parameters.control.solver
        rospy.loginfo("docking node ready (%s%s)", solver, "" if core.shadow is None else ", shadow")

    @property
    def _core(self) -> Core:
        """Of the dock in use."""
        return self._in_use.core

    def _make_core(self, entry: DockEntry) -> Core:
        core = self._maker.make(entry)
        if self._live is not None:
            self._live.adopt(core)
        return core

    def _subscribe(self) -> None:
        """Callbacks only enqueue, so that every input is worked by one thread in the order of its arrival."""
        topics = (
            ("odom", OdometryMsg, 100),
            ("detections", MarkerDetectionArray, 100),
            ("obstacles", ObstacleArray, 10),
        )
        for topic, kind, size in topics:
            rospy.Subscriber(topic, kind, lambda m, t=topic: self._enqueue(t, m), queue_size=size, tcp_nodelay=True)
        rospy.Subscriber(self._camera_info, CameraInfo, self._inputs.calibrated, queue_size=10)
        rospy.Subscriber("charging_contact", Bool, lambda m: self._inbox.put("contact", m.data), queue_size=10)

    def _enqueue(self, kind: str, content: Any) -> None:
        if kind == "odom":
            self._age.arrived(content.header.stamp)
        self._inputs.heard(kind, content)
        self._inbox.put(kind, content)

    def _handlers(self) -> dict[str, Handler]:
        """What is done with each kind of input."""
        return {
            "odom": self._on_odometry,
            "detections": self._on_detections,
            "obstacles": lambda message: self._obstacles.take(message, self._out.odom_frame),
            "contact": lambda closed: setattr(self, "_contact", bool(closed)),
            "goal": lambda goal: self._on_goal(*goal),
            "cancel": self._on_cancel,
            "gate": lambda message: self._on_gate(self._gate.on_state(message)),
            "gate silent": lambda _: self._on_gate(self._gate.silence()),
            "client lost": lambda _: self._on_client_lost(),
            "watchdog": lambda _: self._on_watchdog(),
        }

    def _answer(self, kind: str, content: Any) -> None:
        """Say that this input has been worked through, where the simulator waits for it."""
        if kind in ("odom", "detections", "obstacles"):
            self._out.done(kind, content.header)
        elif kind == "contact":
            self._out.done("charging_contact", Header())

    def _on_odometry(self, message: OdometryMsg) -> None:
        stamp = message.header.stamp.to_sec()
        self._age.begin()
        if stamp < self._out.stamp.to_sec() - TIME_JUMP:  # of the last message, whether it was used or not
            self._abort(ResultCode.ODOMETRY_LOST, "time went backward")
            self._in_use.forget()
            self._age.start_anew()
            self._cycle = -1
        self._note_frames(message)
        odometry = conversions.odometry(message)
        if self._core.sequence.add_odometry(self._core.vehicle.odometry(odometry)):
            self._odometry = odometry
        else:
            rospy.logwarn_throttle(1.0, "odometry refused: not finite, or its stamp %.3f is not newer", stamp)
        self._out.stamp = max(self._out.stamp, message.header.stamp) if self._cycle >= 0 else message.header.stamp
        cycle = math.floor(stamp / self._period + 1e-6)
        if cycle > self._cycle:
            self._cycle = cycle
            if self._age.behind(self._out.stamp) <= self._period:
                self._control(stamp)

    def _note_frames(self, message: OdometryMsg) -> None:
        """Odometry of another body, or in another frame, does not go on from where the last one was."""
        before = self._out.odom_frame, self._out.base_frame
        frames = message.header.frame_id or before[0], message.child_frame_id or before[1]
        if self._odometry is not None and frames != before:
            text = f"the odometry is that of {frames[1]} in {frames[0]}, it was that of {before[1]} in {before[0]}"
            rospy.logwarn_throttle(1.0, "%s: the dock is forgotten", text)
            self._abort(ResultCode.ODOMETRY_WRONG, f"{text}: do two nodes publish it?")
            self._in_use.forget()
        self._out.odom_frame, self._out.base_frame = frames

    def _control(self, now: float) -> None:
        """One control cycle, at the first odometry in each period of message time."""
        self._diagnostics.cycle()
        self._set_obstacles(now)
        self._tell_place()
        if self._core.shadow is not None:
            command = self._core.shadow.update(now)
            self._report(self._core.vehicle.command(command or Command(v=0.0, omega=0.0)), "SHADOW")
            return
        self._in_use.tell_docked(self._out.stamp, self._contact)
        contradiction = self._inputs.contradiction(sees=self._goals.kind == "dock")
        if contradiction is not None:
            self._abort(*contradiction)
        if self._core.sequence.active:
            self._core.sequence.held, self._core.sequence.held_by = self._gate.holds(now), self._gate.held_by
            step = self._core.sequence.update(now, self._contact)
            step = step if step.result is None else replace(step, result=self._gate.named(step.result))
            ask = step.result is not None or self._age.behind(self._out.stamp) <= OUT_OF_DATE
            self._send(step, ask=ask)
            if not ask:
                self._core.sequence.withhold(now)
        else:
            if self._zeros > 0:
                self._zeros -= 1
                self._out.request(0.0, 0.0)
            self._report(Command(v=0.0, omega=0.0), "")

    def _set_obstacles(self, now: float) -> None:
        estimate, newest = self._core.observer.estimate(), self._core.observer.odometry.newest
        dock = self._core.observer.prior if estimate is None else estimate.pose
        obstacles = self._obstacles.now(self._out.odom_frame, dock)
        if dock is not None and newest is not None and self._core.parameters.control.walls:
            obstacles = [*obstacles, *self._in_use.walls_left(dock, newest.pose)]
        self._core.controller.set_obstacles(obstacles)
        self._core.sequence.unsure = self._obstacles.trouble(now) or self._inputs.unsure()

    def _tell_place(self) -> None:
        """The gate: how fast the chair may be where it is, and where the bay's walls are."""
        estimate, newest = self._core.observer.estimate(), self._core.observer.odometry.newest
        if self._core.shadow is not None or newest is None:
            return
        dock = None if estimate is None else estimate.pose
        self._zone.update(self._out.stamp, dock, newest.pose, backs_out=self._core.sequence.backs_out)
        if self._walls is None:
            return
        if estimate is not None and estimate.blind_distance > self._core.parameters.sequence.max_blind_distance:
            dock = None
        docks = self._core.sequence.active and not self._core.sequence.paused
        base = self._core.vehicle.pose(newest.pose)
        self._walls.update(self._out.stamp, self._core.dock.bay, dock, base, docks=docks)

    def _send(self, step: Step, *, ask: bool = True, release: bool = True) -> None:
        command = self._core.vehicle.command(step.command)
        if ask and (step.phase is not Phase.PAUSED or self._zeros > 0):  # paused: no consent, and nothing to ask for
            self._out.request(command.v, command.omega)
            self._zeros = max(0, self._zeros - 1)
        self._report(command, step.phase.name)
        self._diagnostics.step(step, self._core.sequence.held_by if self._core.sequence.held else "")
        self._goals.publish(step)
        if step.result is not None:
            if step.result.success and not self._core.sequence.staging:
                self._in_use.watch.reached(self._out.stamp.to_sec(), docked=step.phase is not Phase.UNDOCKING)
            self._zeros = ZEROS_AFTER_GOAL
            self._diagnostics.installation = self._core.sequence.installation
            self._client.end()
            if release:
                self._gate.release(step.result)
            self._core.remember()

    def _report(self, command: Command, phase: str) -> None:
        estimate, counters = self._core.observer.estimate(), self._core.controller.counters
        fallbacks = counters.shifted + counters.braked - self._fallbacks_before
        age = -1.0 if estimate is None else estimate.age
        self._out.report(command, phase, fallbacks, age)
        self._diagnostics.report(command, age)

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        stamp = message.header.stamp
        self._diagnostics.answered()
        if not self._dock_services.about(message):
            return
        hypotheses, markers = conversions.hypotheses(message), conversions.marker_sights(message)
        fusion = self._core.sequence.add_detections(stamp.to_sec(), hypotheses, markers)
        if message.dock:
            self._out.innovation(stamp, fusion)
        if not fusion.outcome.accepted:
            return
        estimate = self._core.observer.estimate()
        if estimate is not None:
            self._out.dock(stamp, estimate)

    def _on_goal(self, kind: str, handle: Any) -> None:
        goal, now = handle.get_goal(), self._out.stamp.to_sec()
        if self._goals.active and self._goals.kind != kind:
            return self._goals.refuse(kind, handle, ResultCode.BUSY, f"{self._goals.kind} is active")
        if self._core.observer.odometry.newest is None:
            return self._goals.refuse(kind, handle, ResultCode.ODOMETRY_LOST, "no odometry yet")
        if self._dock_services.loading:
            return self._goals.refuse(kind, handle, ResultCode.BUSY, "the docks are being loaded")
        try:
            name = dock_of(kind, goal, self._in_use.docks.database, self._core.dock.name)
            prior = check_goal(kind, goal, self._tf, self._out.odom_frame)
            if kind == "dock":
                self._check_way_to(name, search=prior is not None)
            self._gate.arm(undock=kind == "undock")  # a new goal is a new consent
        except RefusedError as refused:
            # Whoever gave it has let go of the goal before: actionlib's simple client forgets it and cannot cancel it.
            self._abort(ResultCode.CANCELED, f"replaced by a goal that is refused: {refused.text}")
            return self._goals.refuse(kind, handle, refused.code, refused.text)
        self._abort(ResultCode.CANCELED, "replaced by a new goal", release=False)
        self._goals.accept(kind, handle)
        self._in_use.use(name, self._out.stamp)
        self._client.begin(handle.goal)
        self._inputs.begin()
        counters = self._core.controller.counters
        self._fallbacks_before = counters.shifted + counters.braked
        if kind == "dock":
            self._core.sequence.start_dock(now, goal.timeout, prior, staging=goal.staging_only)
        else:
            self._core.sequence.start_undock(now, goal.timeout, force=goal.force)

    def _follow(self, core: Core, left: DockEstimate | None) -> None:
        """Another dock is in use."""
        self._obstacles.leave_dock(None if left is None else left.pose)
        if self._odometry is not None:
            core.sequence.add_odometry(core.vehicle.odometry(self._odometry))
        self._diagnostics.use(core.controller, core.observer)
        self._zone.use(core.chair, core.dock)

    def _check_way_to(self, name: str, *, search: bool) -> None:
        why_not = self._in_use.watch.why_not_to(name, search=search)
        if why_not:
            raise RefusedError(ResultCode.DOCKED_ELSEWHERE, why_not)

    def _why_not_reload(self) -> str:
        return f"a goal to {self._goals.kind} is active" if self._goals.active else ""

    def _take_docks(self, loaded: Loaded[Core]) -> str:
        return self._in_use.take(loaded, self._out.stamp)

    def _on_cancel(self, handle: Any) -> None:
        if self._goals.is_current(handle):
            self._abort(ResultCode.CANCELED, "cancelled")

    def _on_gate(self, loss: Loss | None) -> None:
        if loss is None:
            return
        if loss.code in BY_A_PERSON and self._core.sequence.can_pause:
            self._gate.release()
            self._zeros = ZEROS_AFTER_GOAL
            self._send(self._core.sequence.pause(self._out.stamp.to_sec(), loss.code, loss.text))
        else:
            self._abort(loss.code, loss.text)

    def _on_watchdog(self) -> None:
        """By now odometry may have come: the watching thread may have been the first that ran after a long search."""
        if self._age.silence() > self._core.parameters.sequence.odometry_timeout:
            self._abort(ResultCode.ODOMETRY_LOST, "no odometry arrives")

    def _on_client_lost(self) -> None:
        """By now another goal may be worked on."""
        why = self._client.lost()
        if why:
            self._abort(ResultCode.CLIENT_LOST, why)

    def _go_on(self) -> str:
        """Empty, or why the paused goal does not go on."""
        if not self._core.sequence.paused:
            return "no goal is paused"
        try:
            self._gate.arm(undock=self._goals.kind == "undock")  # a person asks for it: a new consent
        except RefusedError as refused:
            return refused.text
        self._core.sequence.resume(self._out.stamp.to_sec())
        return ""

    def _abort(self, code: ResultCode, text: str, *, release: bool = True) -> None:
        """`release`: the consent, too; else it is the next goal's already."""
        if self._core.sequence.active:
            self._send(self._core.sequence.abort(self._out.stamp.to_sec(), code, text), release=release)

    def _watch(self) -> None:
        """Zero when the odometry stops or the gate is silent during a goal, even when the worker is busy."""
        limit = self._core.parameters.sequence.odometry_timeout
        while not rospy.is_shutdown():
            before = time.monotonic()
            time.sleep(0.05)
            if time.monotonic() - before > STOOD_STILL:
                self._gate.stood_still(time.monotonic() - before)
            if self._core.sequence.active and self._age.silence() > limit:
                self._out.request(0.0, 0.0)
                self._inbox.put("watchdog", None)
            if self._core.sequence.active and self._gate.silence() is not None:
                self._inbox.put("gate silent", None)
            if self._core.sequence.active and self._client.lost():
                self._inbox.put("client lost", None)

    def _on_shutdown(self) -> None:
        self._out.close()
        with contextlib.suppress(rospy.ROSException):  # its client gets a result, unless a publisher is closed already
            self._abort(ResultCode.UNKNOWN, "the docking node ends")
        for _ in range(3):
            if self._core.shadow is None:
                self._out.request(0.0, 0.0)
            time.sleep(0.02)
