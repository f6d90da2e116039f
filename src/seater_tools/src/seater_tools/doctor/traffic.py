"""Nodes, topics, rates, stamps and clocks of a running system."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from seater_tools.doctor.observations import NOT_RUNNING, Live, Observations, Traffic
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong

FEWEST = 5  # messages from which a rate and an age can be told
# Topics that must arrive: who sends them, and least rate [Hz]. Slower odometry or images slow the chair down
# (docs/explanation/controller.md); the gate says its state ten times per second.
NEEDED = {
    "odom": ("the chair's driver", 10.0),
    "image": ("the camera driver", 8.0),
    "camera_info": ("the camera driver", 8.0),
    "detections": ("the node marker_detector", 8.0),
    "gate_state": ("the node safety_gate", 8.0),
}
COUNTED = 0.97  # of a rate: one of 10 Hz, counted over 4 s with jitter, is 9.7 Hz or more
ALONE = ("odom", "image", "gate_state", "detections", "cmd_vel")  # topics that two senders would spoil
STREAM_AGES = {
    "odom": 0.25,
    "image": 0.4,
}  # [s] largest age of a stamp at arrival (controller: 0.34 s is ODOMETRY_LOST)
# What launch arguments switch on, whatever the file says: panel, joystick_hold, emergency_stop of wheelchair.launch.
STRICTER = ("safety/hold_to_run", "safety/emergency_stop_timeout")
ARGUMENTS = ("controller/sequence/installation_check",)  # that wheelchair.launch always gives, whatever the file says
AHEAD = 0.02  # [s] that a stamp may lie in the future: clocks of one computer, rounding


def simulated_time(observations: Observations) -> Verdict:
    """The gate refuses simulated time, but in lock-step."""
    name, live = "clock", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if live.simulated_time and not live.lock_step:
        remedy = "end the simulation, rosparam set use_sim_time false, and start everything anew"
        return wrong(name, "use_sim_time is true: left by a simulation on the same master", remedy)
    return good(name, "simulated, in lock-step" if live.simulated_time else "the computer's")


def nodes(observations: Observations) -> Verdict:
    """Somebody sends and somebody listens."""
    name, live = "nodes", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    missing = [
        f"nobody sends {_called(live, role)} ({who})" for role, (who, _) in NEEDED.items() if not _sent(live, role)
    ]
    if not live.asks_to_drive and not _sent(live, "velocity_request"):
        missing.append(f"nobody sends {_called(live, 'velocity_request')} (the node docking)")
    motors = live.topics.get("cmd_vel")
    if motors is None or not motors.listeners:
        missing.append(f"nobody listens to {_called(live, 'cmd_vel')} (the motors)")
    if missing:
        remedy = (
            "start it, or give its topic to the launch file (roslaunch --ros-args seater_bringup wheelchair.launch)"
        )
        return wrong(name, "; ".join(missing), remedy)
    return good(name, "camera, perception, docking, gate and chair are there")


def single_senders(observations: Observations) -> Verdict:
    """One node on each topic that must have one."""
    name, live = "senders", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    several = [t for t in map(live.topics.get, ALONE) if t is not None and len(t.publishers) > 1]
    if several:
        text = "; ".join(f"{t.name} has {len(t.publishers)} senders: {', '.join(t.publishers)}" for t in several)
        return wrong(name, text, "end all but one (rosnode kill NAME)")
    return good(name, "one for each topic")


def rate_of(role: str) -> Callable[[Observations], Verdict]:
    """The check that a needed topic arrives, and often enough."""
    who, least = NEEDED[role]
    name = f"{role} rate"

    def check(observations: Observations) -> Verdict:
        live = observations.live
        if live is None:
            return unknown(name, NOT_RUNNING)
        if not _sent(live, role):
            return unknown(name, "nobody sends it")
        if role == "detections" and len(_arrivals(live, "image")) < FEWEST:
            return unknown(name, "no images arrive")
        if role == "detections" and (live.pictures.info is None or not live.pictures.sizes_agree):
            return unknown(name, "camera_info comes first")
        topic = live.topics[role]
        hertz = _rate(topic, live.duration)
        text = f"{hertz:.0f} Hz on {topic.name}"
        if len(topic.arrivals) == 0:
            return wrong(name, f"nothing arrives on {topic.name}", f"look at {who} and its log")
        return (
            good(name, text)
            if hertz >= COUNTED * least
            else wrong(name, f"{text}, {least:.0f} are needed", f"look at {who}")
        )

    return check


def stamps_of(role: str) -> Callable[[Observations], Verdict]:
    """The check that stamps advance and are of this computer's clock."""
    who, oldest = NEEDED[role][0], STREAM_AGES[role]
    name = f"{role} stamps"

    def check(observations: Observations) -> Verdict:
        live = observations.live
        if live is None:
            return unknown(name, NOT_RUNNING)
        topic = live.topics.get(role)
        if topic is None or len(topic.stamps) < FEWEST:
            return unknown(name, "too few messages")
        if np.all(topic.stamps == 0.0):
            return wrong(name, "stamps are 0", f"{who} must fill in header.stamp")
        if np.any(np.diff(topic.stamps) <= 0.0):
            stands = int(np.sum(np.diff(topic.stamps) <= 0.0))
            return wrong(name, f"{stands} of {len(topic.stamps)} stamps do not advance", f"look at {who}")
        age = float(np.median(topic.arrivals - topic.stamps))
        text = f"{1000 * age:.0f} ms old at arrival"
        if age < -AHEAD:
            remedy = "let one clock stamp everything: chrony on both computers, or the driver's host time"
            return wrong(name, f"{1000 * -age:.0f} ms in the future", remedy)
        if age > oldest:
            remedy = f"{who} must stamp by this computer's clock (chrony), at the time of measuring, and send at once"
            return wrong(name, f"{text}, at most {1000 * oldest:.0f}", remedy)
        return good(name, text)

    return check


def told(observations: Observations) -> Verdict:
    """The running nodes were given what the files say now."""
    name, live = "files in use", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    compared = [role for role in live.told if role in observations.files and not observations.files[role].error]
    if not compared:
        return unknown(name, "no node says what it was given")
    differing = [where for role in compared for where in _differences(observations, live, role)]
    if differing:
        remedy = (
            "start the nodes anew after an edit; or name the files that they were started with (--chair, --dock ...)"
        )
        return wrong(name, f"the running nodes have other values: {'; '.join(differing[:4])}", remedy)
    return good(name, f"{', '.join(compared)} as in the files")


def _differences(observations: Observations, live: Live, role: str) -> list[str]:
    here, there = _leaves(observations.files[role].values), _leaves(live.told[role])
    strict = {f"{role}/{key}" for key in there if f"{role}/{key}" in STRICTER and _stricter(here.get(key), there[key])}
    return [
        f"{role}/{key} {there.get(key, 'none')} (file {here.get(key, 'none')})"
        for key in sorted(here.keys() | there.keys())
        if not _same(here.get(key), there.get(key)) and f"{role}/{key}" not in (*strict, *ARGUMENTS)
    ]


def _stricter(file: object, told: object) -> bool:
    """Switched on, where the file has it off."""
    return isinstance(told, int | float) and float(told) > 0.0 and not file


def _leaves(values: object, prefix: str = "") -> dict[str, object]:
    """All single values by their path."""
    if isinstance(values, dict):
        items = [(str(key), value) for key, value in values.items()]
    elif isinstance(values, list):
        items = [(str(i), value) for i, value in enumerate(values)]
    else:
        return {prefix: values}
    return {k: v for key, value in items for k, v in _leaves(value, f"{prefix}/{key}" if prefix else key).items()}


def _same(a: object, b: object) -> bool:
    numbers = isinstance(a, int | float) and isinstance(b, int | float)
    return abs(float(a) - float(b)) <= 1e-9 if numbers else a == b  # type: ignore[arg-type]


def _sent(live: Live, role: str) -> bool:
    topic = live.topics.get(role)
    return topic is not None and bool(topic.publishers)


def _rate(topic: Traffic, duration: float) -> float:
    """[Hz] by the intervals between messages; of a few messages by their number."""
    if len(topic.arrivals) < FEWEST or not topic.arrivals[-1] > topic.arrivals[0]:
        return len(topic.arrivals) / duration
    return float((len(topic.arrivals) - 1) / (topic.arrivals[-1] - topic.arrivals[0]))


def _arrivals(live: Live, role: str) -> np.ndarray:
    return live.topics.get(role, Traffic(role)).arrivals


def _called(live: Live, role: str) -> str:
    return live.topics[role].name if role in live.topics else role
