"""The faults that are tried, and how a docking has to end with each."""

from __future__ import annotations

from dataclasses import dataclass

# Where the fault begins: distance of base_link from the docking pose [m]. The first is in front of the bay.
PLACES = {"way": 1.5, "bay": 0.5}
AT_ONCE = 1.5  # [s] from the fault to rest, of what gate and motors notice; braking from 0.6 m/s included
BLIND = 4.0  # [s] of what only the images tell: the chair drives on for the blind distance first


@dataclass(frozen=True)
class Case:
    """A fault. `action`: as ros/fault_actions.py carries it out; `codes`: names of the results that are right."""

    name: str
    action: tuple[str, ...]
    codes: frozenset[str]
    rest: float = BLIND  # [s] longest time from the fault to rest
    recovers: bool = True  # a new goal docks once the fault is gone
    before: bool = False  # it is there before the goal is given
    launch: tuple[str, ...] = ()  # further arguments of wheelchair.launch, as name=value
    safety: tuple[str, ...] = ()  # other values of safety.yaml, as name=value


def _case(name: str, action: str, codes: str, rest: float = BLIND, recovers: bool = True, safety: str = "") -> Case:
    words = tuple(safety.split())
    return Case(name, tuple(action.split()), frozenset(codes.split()), rest, recovers, safety=words)


CASES = [
    _case("emergency stop pressed for 1 s", "emergency_stop 1.0", "EMERGENCY_STOP", AT_ONCE),
    _case("joystick back for 1 s", "joystick -0.2 0.0 1.0", "STOPPED_BY_USER", 2.5),
    _case("camera frozen, fresh stamps", "fail camera frozen", "WHEELS_SLIP MARKER_LOST INCONSISTENT"),
    _case("camera off", "fail camera off", "MARKER_LOST"),
    _case("lens covered", "fail camera black", "MARKER_LOST"),
    _case("markers covered", "fail camera cover", "MARKER_LOST"),
    _case("images of NaN", "fail camera nan", "MARKER_LOST"),
    _case("camera_info of NaN", "fail camera nan_camera_info", "MARKER_LOST"),
    _case("camera_info with a NaN in D", "fail camera nan_distortion", "MARKER_LOST"),
    _case("camera_info of half the size", "fail camera resized 0.5", "INCONSISTENT", AT_ONCE),
    _case("an image a second", "fail camera slow 1.0", "SUCCESS MARKER_LOST"),
    _case("images 0.5 s late", "fail camera late 0.5", "MARKER_LOST INCONSISTENT SUCCESS"),
    _case("dock moved aside by 0.3 m", "fail camera dock_moved 0.0 0.3", "INCONSISTENT MARKER_LOST", recovers=False),
    _case("camera turned by 5 deg", "fail camera knocked 5.0", "INCONSISTENT MARKER_LOST", 60.0),
    _case("focal length told 10 % too long", "fail camera focal 1.1", "INCONSISTENT", AT_ONCE),
    _case("odometry frozen", "fail odometry frozen", "ODOMETRY_WRONG", BLIND),
    _case("odometry off", "fail odometry off", "ODOMETRY_LOST", AT_ONCE),
    _case("odometry without stamps", "fail odometry zero_stamps", "ODOMETRY_LOST", AT_ONCE),
    _case("odometry of NaN", "fail odometry nan", "ODOMETRY_LOST", AT_ONCE),
    _case("odometry once a second", "fail odometry slow 1.0", "ODOMETRY_LOST", AT_ONCE),
    _case("odometry of another body", "fail odometry other_frame 0.3", "ODOMETRY_WRONG", AT_ONCE),
    _case("odometry 30 % too long", "fail odometry scale 1.3", "INCONSISTENT WHEELS_SLIP MARKER_LOST SUCCESS"),
    _case("odometry jumps by 0.3 m", "fail odometry jump 0.3", "INCONSISTENT MARKER_LOST SUCCESS ODOMETRY_WRONG"),
    _case("twist zero", "fail odometry zero_twist", "SUCCESS ODOMETRY_WRONG"),
    _case("runs away with 0.4 m/s", "fail plant runaway 0.4", "RUNAWAY", AT_ONCE),
    _case("motors do not turn", "fail plant stuck", "BLOCKED", 2.5),
    _case("left motor dead", "fail plant left_motor_dead", "BLOCKED RUNAWAY WRONG_DIRECTION MARKER_LOST"),
    _case("drives backward when asked forward", "fail plant reversed", "WRONG_DIRECTION", 2.0),
    _case("base keeps the last command", "fail plant deaf", "RUNAWAY", BLIND),
    _case("docking node stands still for 1 s", "stop /docking 1.0", "GATE_LOST", AT_ONCE),
    _case("docking node killed", "signal kill /docking", "UNKNOWN", AT_ONCE),
    _case("perception killed", "signal kill /marker_detector", "MARKER_LOST SUCCESS"),
    _case("safety gate killed", "signal kill /safety_gate", "GATE_LOST UNKNOWN", AT_ONCE, recovers=False),
    _case("second publisher of requests", "foreign 0.3 1.0", "GATE_LOST", AT_ONCE),
    _case("two tell obstacles, in turns", "second box+nothing obstacles", "BLOCKED", AT_ONCE),
    _case("a second detector", "second repeat detections", "INCONSISTENT", AT_ONCE),
    _case("a second camera", "second repeat camera/color/image_raw camera/color/camera_info", "INCONSISTENT", AT_ONCE),
    _case("a second odometry", "second repeat odom", "ODOMETRY_WRONG", AT_ONCE),
    _case("a second joystick", "second repeat user_cmd_vel", "GATE_LOST", AT_ONCE),
    _case("joystick forward for 5 s", "joystick 0.3 0.0 5.0", "STOPPED_BY_USER", 7.5),
    _case("stop button falls silent", "heartbeat", "EMERGENCY_STOP", AT_ONCE, safety="emergency_stop_timeout=0.5"),
    _case("docking node stands still for 5 s", "stop /docking 5.0", "GATE_LOST UNKNOWN", AT_ONCE),
    _case("perception stands still for 1 s", "stop /marker_detector 1.0", "MARKER_LOST SUCCESS"),
    _case("perception stands still for 5 s", "stop /marker_detector 5.0", "MARKER_LOST SUCCESS"),
    _case("safety gate stands still for 1 s", "stop /safety_gate 1.0", "GATE_LOST", AT_ONCE),
    _case("safety gate stands still for 5 s", "stop /safety_gate 5.0", "GATE_LOST", AT_ONCE),
    _case("camera stands still for 1 s", "stop /camera 1.0", "MARKER_LOST SUCCESS"),
    _case("camera stands still for 5 s", "stop /camera 5.0", "MARKER_LOST SUCCESS"),
    _case("base stands still for 1 s", "stop /plant 1.0", "ODOMETRY_LOST"),  # and the simulated world with it
    _case("rosnode kill of the docking node", "rosnode_kill /docking", "UNKNOWN GATE_LOST", AT_ONCE),
    _case("rosnode kill of perception", "rosnode_kill /marker_detector", "MARKER_LOST SUCCESS"),
    _case("rosnode kill of the safety gate", "rosnode_kill /safety_gate", "GATE_LOST UNKNOWN", AT_ONCE, recovers=False),
    _case("another camera mount on /tf_static", "tf_static base_link camera_link 0.9", "SUCCESS"),
    _case("live parameters changed", "live v_max 0.3 omega_max 0.4", "SUCCESS"),
    _case("docks loaded anew", "reload", "SUCCESS"),
    _case("goal with a time-out of NaN", "goal nan_timeout", "CANCELED", AT_ONCE),
    _case("goal with a pose of NaN", "goal nan_pose", "CANCELED", AT_ONCE),
    _case("goal to an unknown dock", "goal unknown", "CANCELED", AT_ONCE),
    _case("goals and cancels for 2 s, 50 a second", "goal storm", "CANCELED", 3.5),
]
