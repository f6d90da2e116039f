"""The gate's motion monitor on dockings of the independent chair: no alarm while it obeys, one when it does not.

More of them, all rows and seeds 1000 to 1003, by hand: SEATER_MONITOR_SEEDS=4 pytest -k obeys (minutes).
"""

import os
from pathlib import Path

import numpy as np
import pytest

import seater_safety
from seater_eval.judge.cases import Row, rows
from seater_eval.judge.plant.faults import Fault
from seater_eval.judge.run import Job, Log, run

CONFIG = Path(__file__).resolve().parents[3] / "config"
DEFAULTS = {entry["key"]: entry["default"] for entry in seater_safety.describe_parameters()}
PERIOD = 0.02  # [s] of the gate's output
SEEDS = int(os.environ.get("SEATER_MONITOR_SEEDS", "0"))
ALL = [("issue", seed) for seed in range(3 * SEEDS)] + [
    (row.name, seed) for row in [*rows()["effects"], *rows()["turned"], *rows()["beside"]] for seed in range(SEEDS)
]
# Castors and slope at twice their values (0.2 rad/s, 4 deg); delay of 0.25 s and lags up to 0.3 s; slow odometry.
SOME = [
    ("castors_2x", 0),
    pytest.param("slope_2x", 1, marks=pytest.mark.extensive),
    ("odometry_rate_5", 0),
    pytest.param("zero_twist", 0, marks=pytest.mark.extensive),
]


def alarm(log: Log) -> tuple[float, seater_safety.GateState, str] | None:
    """Time [s], state and reason of the first alarm of gate and monitor behind this driver, as the node wires them."""
    gate, monitor = seater_safety.VelocityGate(**DEFAULTS), seater_safety.MotionMonitor(**DEFAULTS)
    end = log.motion.times[-1]
    ticks = [(time, 0, 0.0, 0.0) for time in np.arange(0.0, end, PERIOD)]
    inputs = [(t, 1, v, w) for t, v, w in log.commands] + [(t, 2, v, w) for t, v, w in log.odometry]
    gate.arm(0.0)
    for time, kind, v, omega in sorted(ticks + inputs):
        if kind == 1:
            gate.request(time, v, omega)
        if kind != 2:
            monitor.sent(time, *gate.output(time))
        elif monitor.measured(time, v, omega):
            return time, monitor.cause, monitor.reason
    return None


def row_of(name: str) -> Row:
    return rows()[name][0]


@pytest.mark.parametrize(("name", "seed"), ALL or SOME)
def test_a_chair_that_obeys_brings_no_alarm(name: str, seed: int) -> None:
    values, log = run(Job(str(CONFIG), row_of(name), 1000 + seed))
    assert len(log.odometry) > 50 and values["code"]
    assert alarm(log) is None


def test_one_that_runs_away_brings_one() -> None:
    """1.5 m before the dock, while it is told to slow down on its way into the bay."""
    row = Row("runaway", row_of("issue").effects, fault=Fault("runaway", x=-1.5))
    _, log = run(Job(str(CONFIG), row, 1000))
    began = log.motion.times[np.argmax(log.motion.poses[:, 0] >= -1.5)]
    found = alarm(log)
    assert found is not None and found[1] == seater_safety.GateState.RUNAWAY
    assert 0.0 < found[0] - began < 1.5, found
