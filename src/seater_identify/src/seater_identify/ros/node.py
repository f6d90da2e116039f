"""The node for a real chair: drives the script through the safety gate, records, estimates at the end.

Topics: in `odom`, `cmd_vel_stamped` (what the gate let through), `gate_state`, `dock_pose`; out `velocity_request`.
Services: `~start` begins the drive, `~cancel` stops it (std_srvs/Trigger). Nothing moves before `~start`, which asks
the gate for consent.
Private parameters: ~chair and ~identify (the files in config/), ~chair_file, ~controller_file, ~results (paths), and
~installation, the folder of an installation whose files the new ones replace; empty: none.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import numpy as np
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger, TriggerResponse

from seater_common.files.installation import Installation
from seater_common.geometry import Chair, planar_pose
from seater_common.messages import matrix_of_pose
from seater_common.params import ParameterError, load
from seater_identify.drive.driver import Driver, DriveState
from seater_identify.record.bag import dock_row, make_recording
from seater_identify.record.recording import RecordingError
from seater_identify.report.folder import Sources, copies, write_folder
from seater_identify.report.table import describe
from seater_identify.result.identify import identify
from seater_identify.settings import IdentifySettings
from seater_msgs.msg import GateState
from seater_nmpc.ros.conversions import velocity_request
from seater_nmpc.ros.gate import Gate, Loss
from seater_nmpc.ros.goal_checks import RefusedError

ZEROS = 10  # commands of zero after the end


class IdentifyNode:
    """One lock round the driver and the recording; a timer sends commands."""

    def __init__(self) -> None:
        self._chair = load(Chair, rospy.get_param("~chair"), "~chair")
        self._settings = load(IdentifySettings, rospy.get_param("~identify"), "~identify")
        self._driver = Driver(self._settings, self._chair)
        self._sources = Sources(Path(rospy.get_param("~controller_file")), Path(rospy.get_param("~chair_file")))
        self._installation = Path(rospy.get_param("~installation", "")).expanduser()
        self._results = Path(rospy.get_param("~results")).expanduser()
        self._rows: dict[str, list[Any]] = {"command": [], "odometry": [], "dock": [], "covariance": []}
        self._lock, self._zeros = threading.Lock(), 0
        self._gate = Gate(self._on_gate, lock_step=False)
        self._out = rospy.Publisher("velocity_request", TwistStamped, queue_size=10)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber("cmd_vel_stamped", TwistStamped, self._on_command, queue_size=100, tcp_nodelay=True)
        rospy.Subscriber("dock_pose", PoseWithCovarianceStamped, self._on_dock, queue_size=100)
        rospy.Service("~start", Trigger, self._on_start)
        rospy.Service("~cancel", Trigger, self._on_cancel)
        rospy.Timer(rospy.Duration(self._settings.drive.period), self._on_timer)
        rospy.on_shutdown(self._on_shutdown)
        rospy.loginfo("ready. Clear the area, then: rosservice call %s", rospy.resolve_name("~start"))

    def _on_odometry(self, message: Odometry) -> None:
        stamp, pose = message.header.stamp.to_sec(), planar_pose(matrix_of_pose(message.pose.pose))
        with self._lock:
            self._driver.odometry(stamp, pose, rospy.get_time())
            self._record("odometry", [stamp, *pose])

    def _on_command(self, message: TwistStamped) -> None:
        with self._lock:
            self._record("command", [rospy.get_time(), message.twist.linear.x, message.twist.angular.z])

    def _on_dock(self, message: PoseWithCovarianceStamped) -> None:
        covariance = np.reshape(np.array(message.pose.covariance, dtype=float), (6, 6))
        stamp = message.header.stamp.to_sec()
        row, planar = dock_row(stamp, matrix_of_pose(message.pose.pose), covariance, self._chair)
        if not np.all(np.isfinite(row)) or not np.all(np.isfinite(planar)) or np.any(np.linalg.eigvalsh(planar) <= 0.0):
            return
        with self._lock:
            self._record("dock", row)
            self._record("covariance", planar)

    def _record(self, kind: str, row: Any) -> None:
        if self._driver.state is DriveState.DRIVING or self._zeros > 0:
            self._rows[kind].append(row)

    def _on_gate(self, _: str, message: GateState) -> None:
        with self._lock:
            self._stop_by(self._gate.on_state(message))

    def _stop_by(self, loss: Loss | None) -> None:
        """End the drive where the gate's consent has ended."""
        if loss is not None:
            self._gate.release()
            self._driver.stop(loss.text)

    def _on_start(self, _: Any) -> TriggerResponse:
        with self._lock:
            try:
                self._gate.arm()
            except RefusedError as refused:
                return TriggerResponse(False, refused.text)
            started = self._driver.start(rospy.get_time())
            if not started:
                self._gate.release()
            return TriggerResponse(started, self._driver.text)

    def _on_cancel(self, _: Any) -> TriggerResponse:
        with self._lock:
            self._driver.stop("cancelled")
            return TriggerResponse(True, self._driver.text)

    def _on_timer(self, _: Any) -> None:
        with self._lock:
            if self._driver.state is DriveState.READY:
                return
            self._stop_by(self._gate.silence())
            before = self._driver.state
            command = self._driver.command(rospy.get_time())
            if before is DriveState.DRIVING:
                self._zeros = ZEROS
            elif self._zeros == 0:
                return
            self._publish(*command)
            if self._driver.state is DriveState.DRIVING:
                rospy.loginfo_throttle(5.0, "%d %%: %s", round(100 * self._driver.progress), self._driver.text)
                return
            self._zeros -= 1
            over = self._zeros == 0
        if over:
            threading.Thread(target=self._conclude, daemon=True).start()

    def _publish(self, v: float, omega: float) -> None:
        self._out.publish(velocity_request(rospy.Time.now(), "base_link", v, omega))

    def _conclude(self) -> None:
        """Estimate, also from a drive that was stopped; then the node ends."""
        if self._driver.state is DriveState.STOPPED:
            rospy.logwarn("the drive was stopped: %s", self._driver.text)
        try:
            recording = make_recording(self._rows)
            result = identify(recording)
            rospy.loginfo("\n%s", describe(result))
            note = "the drive" if self._driver.state is DriveState.DONE else f"part of the drive ({self._driver.text})"
            files = write_folder(result, recording, self._chair, self._sources, self._results, note)
            rospy.loginfo("written:\n%s", "\n".join(map(str, files)))
            if result.found:
                self._install()
        except (RecordingError, ParameterError, OSError) as error:
            rospy.logerr("%s", error)
        rospy.signal_shutdown("identification has ended")

    def _install(self) -> None:
        """Raises OSError."""
        if self._installation == Path():
            return
        installation = Installation(self._installation)
        lines = installation.take(copies(self._results))
        rospy.loginfo("%s\nNext: %s", "\n".join(lines), installation.next())

    def _on_shutdown(self) -> None:
        with self._lock:
            self._driver.stop("the node ends")
            self._publish(0.0, 0.0)
