"""Where the unknowns stand, which way markers face, and what is held."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from drive_by_hand import Truth
from test_mount import rows_of

from seater_common.geometry import CameraMount, Dock
from seater_tools.mount.gauge import held_still, moved_as_one
from seater_tools.mount.layout import MOUNT, marker_rotations

TRUTH = Truth()


def test_upright_markers_stand_as_in_the_dock_file() -> None:
    for marker in TRUTH.dock.markers:
        R = marker_rotations(np.array([[*marker.position, marker.normal_yaw, 0.0, 0.0, 0.0]]))[0]
        assert pytest.approx(marker.T_dock_marker()[:3, :3], abs=1e-12) == R


def test_what_is_held_does_not_move() -> None:
    file = rows_of(Dock())
    rows = file + np.array([[0.01, -0.02, 0.005, 0.02], [0.0, 0.01, 0.0, -0.03], [-0.01, 0.0, 0.01, 0.05]])
    still, motion = held_still(file, rows)
    assert moved_as_one(file[:, :3], still - file) == pytest.approx(np.zeros(4), abs=1e-12)
    assert np.abs(motion).max() > 1e-3
    distances = [np.linalg.norm(r[0, :3] - r[1, :3]) for r in (rows, still)]
    assert distances[0] == pytest.approx(distances[1], abs=1e-12)  # moved as one


def test_names_of_the_mount_are_those_of_the_file() -> None:
    assert [field.name for field in dataclasses.fields(CameraMount)] == list(MOUNT)
