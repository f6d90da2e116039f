"""The gate's surroundings in one process: a node that drives, a joystick, an emergency stop, a base that listens."""

from __future__ import annotations

import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rosgraph
import rospkg
import rospy
import yaml
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool

from seater_msgs.msg import GateState, SpeedLimit
from seater_msgs.srv import GateArm, GateArmResponse

PERIOD = 0.05  # [s] of the requests
GATES: list[subprocess.Popen[str]] = []  # that were started


def wait_until(condition: Callable[[], bool], what: str, timeout: float = 15.0) -> float:
    """Polls; returns how long it took [s]."""
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < timeout, f"waited {timeout} s for {what}"
        time.sleep(0.005)
    return time.monotonic() - begin


def start_gate(name: str = "safety_gate", **changes: float) -> subprocess.Popen[str]:
    """A gate with the shipped parameters and these changes of safety.yaml."""
    packages = rospkg.RosPack()
    config = Path(packages.get_path("seater_config"))
    values = {key: yaml.safe_load((config / f"{key}.yaml").read_text()) for key in ("chair", "safety")}
    values["safety"] |= changes
    for key, value in values.items():  # as launch files do: what else is below the name stays
        rosgraph.Master("/test").setParam(f"/{name}/{key}", value)
    command = ["rosrun", "seater_safety", "safety_gate", f"__name:={name}"]
    GATES.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True))
    return GATES[-1]


def end_gates() -> None:
    """Kills every gate that runs."""
    for process in GATES:
        process.kill()
        process.communicate()
    GATES.clear()


class Driver:
    """Sends requests with stamps `stamp_offset` [s] from now while `velocity` is not None; remembers outputs."""

    def __init__(self) -> None:
        self.velocity: tuple[float, float] | None = None
        self.stamp_offset: float | None = 0.0  # None: no stamp
        self.hold: bool | None = None  # what hold-to-run says all the time; None: nothing
        self.heartbeat = False  # the emergency stop says all the time that it is not pressed
        self.commands: list[tuple[float, float, float]] = []  # (monotonic time [s], v, omega)
        self.enabled: list[tuple[float, bool]] = []
        self.state = GateState()
        self._request = rospy.Publisher("velocity_request", TwistStamped, queue_size=1, tcp_nodelay=True)
        self._user = rospy.Publisher("user_cmd_vel", Twist, queue_size=1, tcp_nodelay=True)
        self._stop = rospy.Publisher("emergency_stop", Bool, queue_size=1, tcp_nodelay=True)
        self._hold = rospy.Publisher("hold_to_run", Bool, queue_size=1, tcp_nodelay=True)
        self._limit = rospy.Publisher("speed_limit", SpeedLimit, queue_size=1)
        rospy.Subscriber("cmd_vel", Twist, self._on_command, queue_size=1000, tcp_nodelay=True)
        rospy.Subscriber("motor_enable", Bool, lambda m: self.enabled.append((time.monotonic(), m.data)), queue_size=99)
        rospy.Subscriber("gate_state", GateState, lambda m: setattr(self, "state", m), queue_size=10)
        threading.Thread(target=self._work, daemon=True).start()

    def _on_command(self, message: Twist) -> None:
        self.commands.append((time.monotonic(), message.linear.x, message.angular.z))

    def _work(self) -> None:
        while True:
            if self.velocity is not None:
                self._request.publish(self._message(*self.velocity))
            if self.hold is not None:
                self._hold.publish(self.hold)
            if self.heartbeat:
                self._stop.publish(False)
            time.sleep(PERIOD)

    def _message(self, v: float, omega: float) -> TwistStamped:
        message = TwistStamped()
        if self.stamp_offset is not None:
            message.header.stamp = rospy.Time.now() + rospy.Duration(self.stamp_offset)
        message.twist.linear.x, message.twist.angular.z = v, omega
        return message

    def connect(self) -> None:
        """Until a gate listens and is heard."""
        self.commands.clear()
        links = (self._request, self._user, self._stop, self._hold, self._limit)
        wait_until(lambda: all(link.get_num_connections() > 0 for link in links), "the gate to listen")
        wait_until(lambda: bool(self.commands), "the gate to send")

    def arm(self) -> GateArmResponse:
        """Ask for consent."""
        rospy.wait_for_service("gate_arm", 5.0)
        return rospy.ServiceProxy("gate_arm", GateArm)()

    def drive(self, v: float = 0.15) -> None:
        """From whatever was before to a steady speed, by a new consent."""
        self.velocity, self.stamp_offset = (0.0, 0.0), 0.0
        time.sleep(0.3)  # longer than request_timeout
        answer = self.arm()
        assert answer.granted, answer.reason
        self.velocity = (v, 0.0)
        wait_until(lambda: abs(self.speed - v) < 1e-6, "the chair to drive")

    def deflect(self, v: float) -> None:
        """One joystick command."""
        message = Twist()
        message.linear.x = v
        self._user.publish(message)

    def let_go(self, silent: bool) -> None:
        """Of hold-to-run: said at once, or nothing is said any more."""
        self.hold = None
        if not silent:
            self._hold.publish(False)

    def limit_speed(self, v_max: float) -> None:
        """The largest speed where the chair is [m/s]."""
        self._limit.publish(SpeedLimit(v_max=v_max))

    def press(self, pressed: bool) -> None:
        """The emergency stop; said again until the gate has noticed, as the link may still be that to a dead gate."""

        def noticed() -> bool:
            self._stop.publish(pressed)
            return self.state.emergency_stop is pressed

        wait_until(noticed, "the gate to notice")

    @property
    def speed(self) -> float:
        """Newest output [m/s]."""
        return self.commands[-1][1] if self.commands else 0.0

    @property
    def silence(self) -> float:
        """Since the newest output [s]."""
        return time.monotonic() - self.commands[-1][0]

    def expect_stop(self, within: float) -> None:
        """Zero in time [s], and zero it stays while requests go on."""
        wait_until(lambda: self.speed == 0.0, "the stop", within)
        first = len(self.commands)
        time.sleep(0.3)
        assert all(command[1:] == (0.0, 0.0) for command in self.commands[first:])

    def stop(self, process: Any) -> str:
        """Ends this gate; its output."""
        process.terminate()
        return str(process.communicate(timeout=10)[0])
