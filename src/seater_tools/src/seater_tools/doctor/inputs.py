"""Gate, emergency stop, joystick, contact, odometry at rest, and what nodes complain of."""

from __future__ import annotations

import math

import numpy as np

from seater_tools.doctor.markers import distance
from seater_tools.doctor.observations import NOT_RUNNING, Observations
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong
from seater_tools.stages.tree import stage_of

FINE = ("STOPPED", "REQUEST", "USER")  # states of a gate that nothing is wrong with
NEAR = 0.3  # [m] from the docked pose, beyond which the charging contact cannot be closed
NEUTRAL = 0.02  # [m/s], [rad/s] where safety.yaml does not say it
# [m/s], [rad/s] of an odometry whose chair stands: encoders stand still, gyros drift by up to 0.01 rad/s.
CREEP, DRIFT = 0.01, 0.015


def gate(observations: Observations) -> Verdict:
    """It has nothing to complain of."""
    name, live = "safety gate", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if live.gate is None:
        return unknown(name, "is silent")
    if live.gate.state in FINE or live.gate.emergency_stop:
        return good(name, live.gate.state.lower())
    remedy = "docs/safety.md#state-of-the-gate; a power cut of the motors is reset by rosservice call /gate_reset"
    return wrong(name, f"{live.gate.state}: {live.gate.reason}", remedy)


def emergency_stop(observations: Observations) -> Verdict:
    """It is released. A button that is wired straight to the motors is not heard here."""
    name, live = "emergency stop", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if live.emergency_stop or (live.gate is not None and live.gate.emergency_stop):
        why = live.gate.reason if live.gate is not None else ""
        remedy = "release it; where it latches (emergency_stop_reset), rosservice call /gate_reset"
        return wrong(name, f"pressed{f' ({why})' if why else ''}", remedy)
    topic = live.topics.get("emergency_stop")
    if topic is None or not topic.publishers:
        return unknown(name, "nobody sends emergency_stop: press the button, and see the motors lose their power")
    return good(name, "released")


def joystick(observations: Observations) -> Verdict:
    """At rest it is at zero."""
    name, live = "joystick", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if len(live.joystick) == 0:
        return unknown(name, "is silent")
    safety = observations.files["safety"].values if "safety" in observations.files else None
    neutral = float(safety.get("user_neutral", NEUTRAL)) if isinstance(safety, dict) else NEUTRAL
    largest = float(np.abs(live.joystick).max()) if np.all(np.isfinite(live.joystick)) else math.inf
    text = f"at rest up to {largest:.3f}, {neutral:g} count as let go (user_neutral of safety.yaml)"
    if largest > neutral:
        return wrong(name, text, "let it go; else calibrate its middle or give its driver a deadband")
    return good(name, text)


def contact(observations: Observations) -> Verdict:
    """It is open away from the dock, and there at all where dockings need it."""
    name, live, setup = "charging contact", observations.live, observations.setup
    if live is None:
        return unknown(name, NOT_RUNNING)
    topic = live.topics.get("charging_contact")
    if topic is None or not topic.publishers:
        if live.require_contact:
            remedy = "start the charger's node, or launch with require_contact:=false"
            return wrong(name, "require_contact is set, and nobody sends charging_contact", remedy)
        return unknown(name, "nobody sends charging_contact; dockings do not ask for it")
    if setup.chair is None or setup.dock is None or live.contact is None:
        return unknown(name, "a file is not in order" if live.contact is not None else "no message")
    away = distance(live, setup.chair, setup.dock)
    if live.contact and away is not None and away > NEAR:
        return wrong(
            name, f"closed, {away:.1f} m from the dock", "check its polarity, the cable, or a relay that sticks"
        )
    return good(name, "closed" if live.contact else "open")


def at_rest(observations: Observations) -> Verdict:
    """The odometry of a standing chair stands. Whether it stands, the gate says: it lets nothing through."""
    name, live = "odometry at rest", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    rows = live.odometry
    if len(rows) < 2 or not rows[-1, 0] > rows[0, 0]:
        return unknown(name, "too few messages")
    if not np.all(np.isfinite(rows)):
        return wrong(name, "holds numbers that are not finite", "look at the chair's driver")
    if live.gate is None or live.gate.state in ("REQUEST", "USER"):
        return unknown(name, "the chair drives")
    duration = rows[-1, 0] - rows[0, 0]
    speed = float(np.linalg.norm(rows[-1, 1:3] - rows[0, 1:3])) / duration
    turning = abs(math.remainder(float(rows[-1, 3] - rows[0, 3]), 2.0 * math.pi)) / duration
    text = f"{1000 * speed:.1f} mm/s, {turning:.4f} rad/s"
    if speed > CREEP or turning > DRIFT:
        return wrong(name, text, "does the chair roll? Else: encoder noise, a gyro without its bias taken off at rest")
    return good(name, text)


def base_frames(observations: Observations) -> Verdict:
    """The odometry names its frames as everything else does."""
    name, live = "odometry frames", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if len(live.odometry) == 0:
        return unknown(name, "no odometry arrives")
    frame, child = live.frames
    if not frame or not child or frame == child or frame.startswith("/") or child.startswith("/"):
        text = f"frame_id {frame!r}, child_frame_id {child!r}"
        return wrong(name, text, "the chair's driver must name both, e.g. odom and base_link, without a slash")
    return good(name, f"{child} in {frame}")


def complaints(observations: Observations) -> Verdict:
    """No node reports an error on /diagnostics."""
    name, live = "diagnostics", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    if live.complaints:
        ordered = sorted(live.complaints, key=lambda complaint: stage_of(complaint[0]))  # the first is the cause
        text = "; ".join(f"{entry}: {text}" for entry, text in ordered[:3])
        return wrong(name, text, "begin with the first; all stages: ./seater doctor --stages")
    return good(name, "no errors")
