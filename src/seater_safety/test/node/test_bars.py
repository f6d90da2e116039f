"""The bars of the gate, measured: killed by every signal, latency, hold-to-run let go at random moments.

Takes some minutes, so `./seater test --all` only. With `pytest -s -m extensive` it prints what it measured.
"""

from __future__ import annotations

import signal
import statistics
import subprocess
import time
from collections.abc import Iterator

import numpy as np
import pytest
import rospy
from driver import PERIOD, Driver, end_gates, start_gate, wait_until
from geometry_msgs.msg import TwistStamped

pytestmark = pytest.mark.extensive

Gate = subprocess.Popen[str]
SILENCE = 0.3  # [s] after which a base driver switches the motors off
OFF_WITHIN, LATENCY, RELEASES = 0.3, 1e-3, 100
_HARMLESS = {"SIGCHLD", "SIGCONT", "SIGSTOP", "SIGTSTP", "SIGTTIN", "SIGTTOU", "SIGURG", "SIGWINCH", "SIGPIPE"}
_STOPS = {signal.SIGSTOP}  # kills nobody, but the gate is silent all the same
DEADLY = sorted({s for s in signal.Signals if s.name not in _HARMLESS and s < signal.SIGRTMIN} | _STOPS)
V_MAX, A_STOP, USER_TIMEOUT = 0.6, 1.5, 0.5  # chair.yaml, safety.yaml


def motors_off(driver: Driver, since: float) -> float:
    """[s] after `since` when a base driver has the motors off: told so, or by silence of one of its two topics."""
    told = [at for at, on in driver.enabled if at >= since and not on]
    silent = [max(at for at, *_ in heard) + SILENCE for heard in (driver.commands, driver.enabled)]
    return min([*told, *silent]) - since


@pytest.mark.parametrize("deadly", DEADLY, ids=lambda s: s.name)
def test_killed_the_motors_are_off(driver: Driver, own_gate: Gate, deadly: signal.Signals) -> None:
    driver.drive()
    since = time.monotonic()
    own_gate.send_signal(deadly)
    time.sleep(1.0)
    off = motors_off(driver, since)
    print(f"{deadly.name}: motors off after {off:.2f} s")
    assert driver.silence > SILENCE and off <= OFF_WITHIN + 0.05  # the scheduler's share


def test_latency(driver: Driver, gate: Gate) -> None:
    """From the request to the command, less what one topic takes from this process to itself."""
    driver.drive()
    driver.velocity = None
    echo = rospy.Publisher("echo", TwistStamped, queue_size=1, tcp_nodelay=True)
    heard: list[float] = []
    rospy.Subscriber("echo", TwistStamped, lambda _: heard.append(time.monotonic()), tcp_nodelay=True)
    wait_until(lambda: echo.get_num_connections() > 0, "the echo")
    rng, direct, through = np.random.default_rng(1), [], []
    for k in range(1000):
        message = driver._message(0.15 - 1e-3 * (k % 2), 0.0)
        begin = time.monotonic()
        echo.publish(message)
        wait_until(lambda k=k: len(heard) > k, "the echo", 1.0)
        direct.append(heard[k] - begin)
        message.header.stamp, begin = rospy.Time.now(), time.monotonic()
        before = len(driver.commands)
        driver._request.publish(message)
        changed = driver_heard(driver, before, message.twist.linear.x)
        through.append(changed - begin)
        time.sleep(float(rng.uniform(0.01, 0.06)))
    added = np.array(through) - statistics.median(direct)
    median, late = np.median(added), np.quantile(added, 0.99)
    print(f"added latency: median {1e3 * median:.2f} ms, 99 % {1e3 * late:.2f} ms (one topic {1e3 * direct[0]:.2f} ms)")
    assert median <= LATENCY


def driver_heard(driver: Driver, before: int, v: float) -> float:
    """When a command of this speed [m/s] came, among those after the first `before`."""

    def found() -> float | None:
        return next((at for at, speed, _ in driver.commands[before:] if abs(speed - v) < 1e-6), None)

    wait_until(lambda: found() is not None, f"a command of {v} m/s", 1.0)
    return found() or 0.0


@pytest.fixture
def held_gate(driver: Driver) -> Iterator[Gate]:
    end_gates()
    process = start_gate(hold_to_run=1.0)
    driver.connect()
    yield process
    driver.velocity, driver.hold = None, None
    end_gates()


def test_hold_to_run_let_go(driver: Driver, held_gate: Gate) -> None:
    """At any moment, at any speed: said so, or silent (a lost connection)."""
    rng, rest = np.random.default_rng(2), {False: [], True: []}
    for k in range(RELEASES):
        silent = k % 4 == 3
        driver.hold = True
        time.sleep(3 * PERIOD)
        driver.drive(0.05)
        driver.velocity = (float(rng.uniform(0.1, V_MAX)), float(rng.uniform(-0.3, 0.3)))
        time.sleep(float(rng.uniform(0.0, 1.5)))
        since, speed = time.monotonic(), driver.speed
        driver.let_go(silent)
        wait_until(lambda: driver.commands[-1][1:] == (0.0, 0.0), "the chair to stand", 3.0)
        rest[silent].append(time.monotonic() - since)
        assert rest[silent][-1] <= V_MAX / A_STOP + (USER_TIMEOUT if silent else 0.0) + 0.1, (silent, speed)
        driver.expect_stop(0.05)
        assert not driver.state.motion_allowed
    for silent, times in rest.items():
        how = "silent" if silent else "let go"
        print(f"hold-to-run {how}, {len(times)}: at rest {np.median(times):.2f} s median, {max(times):.2f} s at most")
