"""The gate's node, running freely on the clocks of the machine: every fault of docs/safety.md that is the gate's."""

from __future__ import annotations

import math
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
import rosgraph
import rospy
from driver import Driver, start_gate, wait_until
from std_srvs.srv import Trigger

from seater_msgs.msg import GateState

Gate = subprocess.Popen[str]
BRAKING = 0.15 / 1.5  # [s] from the speed of `drive` by a_stop
SLACK = 0.3  # [s] for a loaded machine


def expect_latched(driver: Driver, cause: int, within: float) -> None:
    """Zero in time, and zero while requests go on. That a new goal drives is shown by the next test."""
    driver.expect_stop(within)
    assert (driver.state.stopped_by, driver.state.motion_allowed) == (cause, False), driver.state


@contextmanager
def publishing(topic: str, kind: str, text: str) -> Iterator[None]:
    """Another node that publishes this 10 times per second."""
    command = ["rostopic", "pub", "-r", "10", topic, kind, text]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def test_it_speaks_at_a_constant_rate_while_standing(driver: Driver, gate: Gate) -> None:
    driver.commands.clear()
    driver.enabled.clear()
    time.sleep(1.0)
    assert 44 <= len(driver.commands) <= 56 and 17 <= len(driver.enabled) <= 23
    assert {command[1:] for command in driver.commands} == {(0.0, 0.0)}
    assert all(enabled for _, enabled in driver.enabled)


def test_without_consent_nothing_moves(driver: Driver, gate: Gate) -> None:
    driver.velocity = (0.4, 0.2)
    time.sleep(0.5)
    assert driver.speed == 0.0 and driver.state.reason == "/docking sends velocity requests without consent"
    answer = driver.arm()
    assert not answer.granted and "still come in" in answer.reason


def test_emergency_stop(driver: Driver, gate: Gate) -> None:
    driver.drive()
    driver.press(True)
    driver.expect_stop(BRAKING + SLACK)
    wait_until(lambda: not driver.enabled[-1][1], "the motors to be switched off", 0.2)
    refusal = driver.arm()
    assert not refusal.granted and refusal.state == GateState.EMERGENCY_STOP
    driver.deflect(0.2)
    driver.expect_stop(0.1)
    driver.press(False)
    time.sleep(0.6)  # the joystick counts as let go
    wait_until(lambda: driver.enabled[-1][1], "the motors to be switched on", 0.2)
    expect_latched(driver, GateState.EMERGENCY_STOP, 0.1)


def test_joystick(driver: Driver, gate: Gate) -> None:
    driver.drive()
    for _ in range(14):
        driver.deflect(-0.2)
        time.sleep(0.05)
    assert driver.speed < -0.1 and driver.state.state == GateState.USER
    refusal = driver.arm()
    assert not refusal.granted and refusal.state == GateState.USER
    driver.deflect(0.0)
    expect_latched(driver, GateState.USER, 0.2 / 1.5 + SLACK)
    driver.deflect(0.2)
    wait_until(lambda: driver.state.state == GateState.USER, "the joystick to drive")


def test_a_slow_zone_holds_for_the_joystick(driver: Driver, gate: Gate) -> None:
    driver.limit_speed(0.05)
    for _ in range(10):
        driver.deflect(0.3)
        time.sleep(0.05)
    assert driver.speed == 0.05
    driver.deflect(0.0)
    driver.expect_stop(SLACK)


def test_a_silent_docking_node(driver: Driver, gate: Gate) -> None:
    """Stopped for a second: braked after 0.25 s, and it does not go on by itself."""
    driver.drive()
    driver.velocity = None
    wait_until(lambda: driver.speed < 0.15, "the brakes", 0.25 + SLACK)
    assert driver.state.motion_allowed
    time.sleep(1.0)
    driver.velocity = (0.15, 0.0)
    expect_latched(driver, GateState.STALE, 0.1)


@pytest.mark.parametrize(
    ("offset", "says"),
    [(None, "no stamp"), (-10.0, "10.0"), (3600.0, "in the future")],
)
def test_stamps(driver: Driver, gate: Gate, offset: float | None, says: str) -> None:
    driver.drive()
    driver.stamp_offset = offset
    driver.expect_stop(0.25 + BRAKING + SLACK)
    wait_until(lambda: not driver.state.motion_allowed, "the consent to end", 1.0)
    assert driver.state.stopped_by == GateState.STALE and says in driver.state.stop_reason


def test_what_is_not_finite(driver: Driver, gate: Gate) -> None:
    driver.drive()
    driver.velocity = (math.nan, 0.0)
    expect_latched(driver, GateState.REFUSED, BRAKING + SLACK)


@pytest.mark.parametrize(
    ("topic", "kind", "text"),
    [
        ("velocity_request", "geometry_msgs/TwistStamped", "{twist: {linear: {x: 0.3}}}"),
        ("cmd_vel", "geometry_msgs/Twist", "{linear: {x: 0.01}}"),
    ],
)
def test_a_second_publisher(driver: Driver, gate: Gate, topic: str, kind: str, text: str) -> None:
    driver.drive()
    with publishing(topic, kind, text):
        wait_until(lambda: driver.state.state == GateState.FAULT, "the fault")
        assert f"/{topic}" in driver.state.reason or "rostopic" in driver.state.reason
        wait_until(lambda: driver.commands[-1][1] in (0.0, 0.01), "the stop", BRAKING + SLACK)
        assert not driver.arm().granted
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the end of the fault")
    expect_latched(driver, GateState.FAULT, 0.1)


def test_a_second_gate(driver: Driver, gate: Gate) -> None:
    driver.drive()
    other = start_gate("other_gate")
    wait_until(lambda: driver.state.state == GateState.FAULT, "the fault")
    assert "beside the safety gate" in driver.state.reason
    time.sleep(BRAKING + SLACK)  # until then one may brake while the other stands
    driver.expect_stop(0.0)
    driver.stop(other)
    wait_until(lambda: driver.state.state == GateState.STOPPED, "the end of the fault")


@pytest.mark.parametrize("way", ["rosnode kill", signal.SIGINT, signal.SIGTERM])
def test_every_way_out_ends_in_zero(driver: Driver, own_gate: Gate, way: str | signal.Signals) -> None:
    driver.drive()
    if isinstance(way, str):
        subprocess.run(["rosnode", "kill", "/safety_gate"], check=True, capture_output=True)
    else:
        own_gate.send_signal(way)
    own_gate.wait(timeout=5.0)
    time.sleep(0.1)
    assert driver.commands[-1][1:] == (0.0, 0.0) and not driver.enabled[-1][1]
    steps = [second[1] - first[1] for first, second in zip(driver.commands, driver.commands[1:], strict=False)]
    assert min(steps) > -0.1, "braked, and not dropped"


def test_a_killed_gate_is_silent_and_another_has_no_consent(driver: Driver, own_gate: Gate) -> None:
    """The base stops by itself then; a new gate begins without a consent, though requests go on."""
    driver.drive()
    own_gate.kill()
    own_gate.wait(timeout=5.0)
    time.sleep(0.5)
    assert driver.silence > 0.4
    again = start_gate()
    driver.connect()
    driver.expect_stop(0.1)
    driver.drive()
    driver.velocity = None
    driver.stop(again)


def test_an_emergency_stop_is_remembered_by_the_next_gate(driver: Driver, own_gate: Gate) -> None:
    """In a parameter; one that somebody has set by hand to anything but a plain no counts, too."""
    driver.press(True)
    time.sleep(0.3)
    own_gate.kill()
    own_gate.wait(timeout=5.0)
    parameters, key = rosgraph.Master("/test"), "/safety_gate/emergency_stop_pressed"
    assert parameters.getParam(key) is True
    parameters.setParam(key, 1)
    again = start_gate()
    driver.connect()
    wait_until(lambda: driver.state.state == GateState.EMERGENCY_STOP, "the stop to be remembered")
    assert not driver.arm().granted
    driver.press(False)
    driver.drive()
    driver.velocity = None
    driver.stop(again)


def test_a_silent_emergency_stop_and_its_reset(driver: Driver, own_gate: Gate) -> None:
    driver.stop(own_gate)
    strict = start_gate(emergency_stop_timeout=0.5, emergency_stop_reset=1)
    driver.connect()
    assert "silent" in driver.arm().reason
    driver.heartbeat = True
    wait_until(lambda: "not reset" in driver.state.reason, "the emergency stop to be heard")
    reset = rospy.ServiceProxy("gate_reset", Trigger)
    assert reset().success
    driver.drive()
    driver.heartbeat = False
    driver.expect_stop(0.5 + BRAKING + SLACK)
    assert driver.state.stopped_by == GateState.EMERGENCY_STOP and not reset().success
    driver.velocity = None
    driver.stop(strict)


def test_simulated_time_that_was_left_is_refused(driver: Driver) -> None:
    master = rosgraph.Master("/test")
    master.setParam("/use_sim_time", True)
    try:
        simulated = start_gate("simulated")
        output = simulated.communicate(timeout=10)[0]
    finally:
        master.deleteParam("/use_sim_time")
    assert simulated.returncode == 1 and "/use_sim_time: is true" in output, output


def test_zz_the_master_dies(driver: Driver, own_gate: Gate, master: subprocess.Popen[bytes]) -> None:
    """The last one, because nothing starts without a master."""
    driver.drive()
    master.kill()
    driver.expect_stop(3.0 + BRAKING + SLACK)
    assert driver.state.stopped_by == GateState.FAULT and driver.state.stop_reason == "the ROS master does not answer"
