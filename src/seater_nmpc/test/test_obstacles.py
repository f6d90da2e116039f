"""Obstacles between the message and the controller: what is refused, where they are held, when they are dropped."""

import math

import numpy as np
import pytest

from seater_common.se2 import transform_points
from seater_nmpc.obstacles import ObstacleMemory, usable_outlines

BOX = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
DOCK = np.array([3.0, -1.0, 0.7])


def test_only_the_unusable_are_dropped_and_named() -> None:
    line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]
    bad = [[0.0, 0.0], [1.0, math.nan], [2.0, 0.0]]
    outlines, complaints = usable_outlines([line, BOX[::-1], bad, np.zeros((0, 2)), BOX[:2]])
    assert len(outlines) == 1 and outlines[0] == pytest.approx(BOX)  # anticlockwise again
    assert [complaint.split(":")[0] for complaint in complaints] == [f"polygon {i}" for i in (0, 2, 3, 4)]
    assert "finite" in complaints[1] and "line" in complaints[0]


def test_in_odom_they_stand_still_while_the_estimate_moves() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=False)
    for moved in (DOCK, DOCK + [0.2, -0.1, 0.05]):
        (seen,) = memory.in_dock(moved)
        assert transform_points(moved, seen) == pytest.approx(BOX)
    assert memory.in_dock(None) == []


def test_bound_to_the_dock_they_move_with_it() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=True)
    for dock in (None, DOCK):
        (seen,) = memory.in_dock(dock)
        assert seen == pytest.approx(BOX)


def test_a_message_replaces_the_one_before() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX, BOX + 3.0], bound_to_dock=True)
    memory.replace([BOX + 1.0], bound_to_dock=True)
    assert len(memory.in_dock(None)) == 1
    memory.replace([], bound_to_dock=True)
    assert memory.in_dock(None) == []


def test_stale_ones_are_dropped_once() -> None:
    memory = ObstacleMemory(0.5)
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.forget_stale(now) for now in (10.0, 10.4)] == [False, False]
    memory.replace([BOX], bound_to_dock=True)  # news: the age begins anew
    assert [memory.forget_stale(now) for now in (10.8, 11.2)] == [False, False]
    assert len(memory.in_dock(None)) == 1
    assert [memory.forget_stale(now) for now in (11.4, 11.5)] == [True, False]
    assert memory.in_dock(None) == []


def test_time_that_goes_backward_drops_nothing() -> None:
    memory = ObstacleMemory(0.5)
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.forget_stale(now) for now in (10.0, 2.0, 2.4)] == [False, False, False]


def test_without_a_time_out_they_hold() -> None:
    memory = ObstacleMemory(0.0)
    memory.replace([BOX], bound_to_dock=True)
    assert [memory.forget_stale(now) for now in (0.0, 1e6)] == [False, False]
    assert len(memory.in_dock(None)) == 1
