"""How well one docking can know the camera's place at best: the Cramer-Rao bound of docs/explanation/plausibility.md.

An extended Kalman filter's covariance is that bound for its model, linearised on the true way; no measurement's value
enters. The images are those of three markers side by side.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step, compose, inverse
from seater_nmpc.observe.measurement import Measurement, in_frame
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.plausibility.installation.installation import Installation

Way = list[tuple[float, float, float]]  # v [m/s], omega [rad/s], duration [s]

LITTLE, USUAL = 0, 1  # slip
STEP, EVERY = 0.01, 10  # [s]; steps between two images
STRAIGHT: Way = [(0.4, 0.0, 4.0), (0.15, 0.0, 5.3)]
CURVED: Way = [(0.3, -0.4, 1.75), (0.3, 0.0, 2.5), (0.3, 0.4, 1.75), (0.2, 0.0, 3.5)]
AHEAD, ASIDE, FAR = (-2.4, 0.0, 0.0), (-2.6, 0.9, 0.0), (-2.8, 0.0, 0.0)


def look(degrees: float) -> Way:
    """A turn on the spot to both sides and back."""
    duration = math.radians(degrees) / 0.4
    return [(0.0, 0.4, duration), (0.0, -0.4, 2.0 * duration), (0.0, 0.4, duration)]


def swing(degrees: float) -> Way:
    """The same as the docking makes it: castors point ahead before each turn."""
    ahead, turn = (0.15, 0.0, 1.0), math.radians(degrees) / 0.3
    return [ahead, (0.0, 0.3, turn), ahead, (0.0, -0.3, 2.0 * turn), ahead, (0.0, 0.3, turn)]


def covariance(dock: np.ndarray) -> np.ndarray:
    """Of the dock (3,) in base_link, as the independent chair's camera sees it."""
    d, bearing, heading = math.hypot(dock[0] + 0.45, dock[1]), math.atan2(dock[1], dock[0]), dock[2]
    across, depth = (0.0004 + 0.0004 * d) / math.sqrt(3.0), (0.0008 + 0.0015 * d * d) / math.sqrt(3.0)
    turn = min((0.002 + 0.003 * d) / math.sqrt(3.0), math.sqrt(2.0) * depth * math.sqrt(3.0) / 0.4)
    R = np.array([[math.cos(bearing), -math.sin(bearing)], [math.sin(bearing), math.cos(bearing)]])
    P = np.zeros((3, 3))
    P[:2, :2], P[2, 2] = R @ np.diag([depth**2, across**2]) @ R.T, turn**2
    J = np.eye(3)
    J[:2, 2] = 0.45 * np.array([-math.sin(heading), math.cos(heading)])  # from the markers to the dock's origin
    return J @ P @ J.T


def bound(way: Way, start: tuple[float, float, float], slip: int = USUAL) -> tuple[float, float]:
    """Standard deviations [mm] of where the docked chair stands, ahead and aside."""
    installation, buffer = Installation(Chair().camera, Dock(), ObserverParameters()), OdometryBuffer(200.0, 0.1)
    truth, odom, count = np.array(start), np.zeros(3), 0
    for v, omega, duration in way:
        for _ in range(round(duration / STEP)):
            truth, odom, count = arc_step(truth, v, omega, STEP), arc_step(odom, v, omega, STEP), count + 1
            buffer.add(Odometry(STEP * count, odom, v, omega))
            chair = buffer.newest
            assert chair is not None
            if count % EVERY == 0:
                dock = inverse(truth)
                seen = in_frame(chair.pose, Measurement(dock, covariance(dock)))
                assert np.allclose(seen.pose, compose(odom, dock))
                installation.add(chair, [seen], seen.pose)
    B, (_, P) = installation._effect.on(np.zeros(3)), installation._filters.found[slip]
    x, y, _ = 1e3 * np.sqrt(np.diag(B @ P @ B.T))
    return float(x), float(y)


@pytest.mark.parametrize(
    ("way", "start", "slip", "expected"),
    [
        (STRAIGHT, AHEAD, USUAL, (35.0, 30.0)),
        (CURVED, ASIDE, LITTLE, (16.0, 7.0)),
        (CURVED, ASIDE, USUAL, (20.0, 13.0)),
        (look(30.0) + STRAIGHT, AHEAD, USUAL, (27.0, 8.4)),
        (look(30.0) + [(0.4, 0.0, 3.0)] + look(30.0) + [(0.2, 0.0, 6.0)], AHEAD, USUAL, (7.6, 6.0)),
        (swing(35.0) + [(0.4, 0.0, 3.25)] + swing(35.0) + [(0.2, 0.0, 4.0)], FAR, USUAL, (2.5, 4.0)),
    ],
)
def test_what_one_docking_can_tell(
    way: Way, start: tuple[float, float, float], slip: int, expected: tuple[float, float]
) -> None:
    assert bound(way, start, slip) == pytest.approx(expected, rel=0.1)
