"""What dockings show of the installation together, and the file that keeps it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from test_installation import CHAIR, DOCK, LIMITS, NOISE, S_CURVE, seen

from seater_common.camera_model import CameraModel
from seater_common.se2 import arc_step
from seater_nmpc.observe.measurement import Measurement, in_frame
from seater_nmpc.observe.odometry.buffer import OdometryBuffer
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import ObserverParameters
from seater_nmpc.plausibility.installation.installation import _MODEL, Installation
from seater_nmpc.plausibility.installation.knowledge import Knowledge, nothing_known
from seater_nmpc.plausibility.installation.memory import Memory, mark_of

MARK = mark_of(CHAIR, DOCK, None)
CERTAIN = 5.0


def docks(installation: Installation, wrong, seed: int, certainty: float = CERTAIN):
    """One more docking: what is found, with what is known before; then it is learned from."""
    truth, odom = np.array([-2.6, 0.9 - 0.2 * seed, 0.7 - 0.1 * seed]), np.array([1.0, 2.0, 0.3])
    rng, buffer = np.random.default_rng(seed), OdometryBuffer(60.0, 0.1)
    installation.restart()
    for k, (v, omega) in enumerate(S_CURVE):
        truth = arc_step(truth, v * 0.98, omega, 0.01)
        odom = arc_step(odom, v, omega, 0.01)
        buffer.add(Odometry(0.01 * (k + 1), odom, v, omega))
        if k % 5 == 0:
            pose = seen(truth, np.array(wrong)) + NOISE * rng.normal(size=3)
            assert buffer.newest is not None
            measured = in_frame(buffer.newest.pose, Measurement(pose, np.diag(NOISE**2)))
            installation.add(buffer.newest, [measured], measured.pose)
    error = installation.error()
    installation.learn(LIMITS, certainty)
    return error


@pytest.fixture
def installation() -> Installation:
    return Installation(CHAIR.camera, DOCK, ObserverParameters())


def test_dockings_together_find_what_one_is_not_sure_of(installation) -> None:
    errors = [docks(installation, (0.022, 0.0, 0.0, 0.0), seed) for seed in range(5)]
    assert not errors[0].is_wrong(LIMITS, CERTAIN) and errors[-1].is_wrong(LIMITS, CERTAIN)
    assert errors[-1].values[0] == pytest.approx(0.022, abs=0.005) and errors[-1].dockings >= 3
    spreads = [error.spread[0, 0] - _MODEL[0] ** 2 for error in errors]  # beyond what no driving makes surer
    assert spreads[-1] < 0.5 * spreads[0] and np.all(np.diff(spreads) < 0.0)


def test_a_right_installation_stays_right(installation) -> None:
    errors = [docks(installation, (0.0, 0.0, 0.0, 0.0), seed) for seed in range(6)]
    assert not any(error.is_wrong(LIMITS, CERTAIN) for error in errors)
    assert installation.known.dockings == 6


def test_a_fault_of_one_docking_is_not_learned(installation) -> None:
    """A camera that was turned during a docking; somebody turns it back."""
    turned = docks(installation, (0.0, 0.0, math.radians(3.0), 0.0), 1)
    assert turned.is_wrong(LIMITS, CERTAIN) and installation.known.dockings == 0
    assert not docks(installation, (0.0, 0.0, 0.0, 0.0), 2).is_wrong(LIMITS, CERTAIN)


def test_a_camera_that_was_put_right_is_believed_again(installation) -> None:
    for seed in range(5):
        docks(installation, (0.08, 0.0, 0.0, 0.0), seed, certainty=99.0)
    assert installation.known.values[0, 0] > 0.06
    for seed in range(5, 8):
        error = docks(installation, (0.0, 0.0, 0.0, 0.0), seed)
    assert installation.known.dockings < 4 and not error.is_wrong(LIMITS, CERTAIN)


def test_what_turns_have_shown_no_docking_without_them_wears_away(installation) -> None:
    shown = Knowledge(1, np.zeros((4, 4)), np.tile(np.diag([0.006, 0.006, 0.003, 0.002]) ** 2, (4, 1, 1)), turned=True)
    installation.known = shown
    docks(installation, (0.02, 0.0, 0.0, 0.0), 1)
    assert installation.known.turned and np.array_equal(installation.known.values, shown.values)
    assert np.all(np.diagonal(installation.known.covariances - shown.covariances, axis1=1, axis2=2) > 0.0)
    installation.learn(LIMITS, CERTAIN, turned=True)
    assert installation.known.dockings == 2 and installation.known.values[0, 0] > 0.002


def test_it_is_kept_for_the_same_installation_only(tmp_path) -> None:
    memory, values = Memory(tmp_path / "new" / "memory.yaml"), np.full((4, 4), 0.001)
    known = Knowledge(3, values, 0.5 * nothing_known().covariances, turned=True)
    assert memory.recall("hall", MARK).dockings == 0
    memory.keep("hall", MARK, known)
    memory.keep("gate", MARK, replace(known, dockings=7))
    found = memory.recall("hall", MARK)
    assert found.dockings == 3 and found.turned and np.array_equal(found.covariances, known.covariances)
    assert memory.recall("gate", MARK).dockings == 7
    lens = CameraModel(640, 480, "plumb_bob", np.zeros(5), np.eye(3), np.eye(3), np.zeros((3, 4)))
    others = {"width": 320, "distortion_model": "none", "D": np.full(5, 0.1), "K": 2.0 * lens.K}
    lenses = [None, lens, *(replace(lens, **{key: value}) for key, value in others.items())]
    assert len({mark_of(CHAIR, DOCK, one) for one in lenses}) == 6
    moved = replace(CHAIR, camera=replace(CHAIR.camera, x=CHAIR.camera.x + 0.001))
    assert memory.recall("hall", mark_of(moved, DOCK, None)).dockings == 0


@pytest.mark.parametrize(
    "damage",
    [
        {"values": [[math.nan] * 4] * 4},
        {"values": [[0.0] * 3] * 4},
        {"values": "many"},
        {"dockings": None},
        {"dockings": -1},
        {"covariances": (-nothing_known().covariances).tolist()},
        {"covariances": (100.0 * nothing_known().covariances).tolist()},
        {"covariances": [[[math.inf] * 4] * 4] * 4},
    ],
)
def test_what_is_damaged_is_not_used(tmp_path, damage) -> None:
    memory = Memory(tmp_path / "memory.yaml")
    memory.keep("hall", MARK, Knowledge(3, np.zeros((4, 4)), 0.5 * nothing_known().covariances))
    content = yaml.safe_load((tmp_path / "memory.yaml").read_text())
    content["hall"] |= damage
    (tmp_path / "memory.yaml").write_text(yaml.safe_dump(content))
    assert memory.recall("hall", MARK).dockings == 0
    (tmp_path / "memory.yaml").write_bytes(b"hall: [\xff")
    assert memory.recall("hall", MARK).dockings == 0
