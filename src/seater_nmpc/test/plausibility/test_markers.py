"""Markers against each other and against the floor: what is right passes, each wrong installation is named."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock, pose_matrix
from seater_common.se2 import inverse
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Kind
from seater_nmpc.plausibility.markers import Markers

CHAIR, DOCK = Chair(), Dock()
NOISE = 0.003  # [m] of a single marker's centre
TOLD = math.radians(0.3)  # [rad] standard deviation of an image's rotation, as perception tells


def judged(mount=CHAIR.camera, scale: float = 1.0, moved=(0.0, 0.0, 0.0), images: int = 40, x: float = -0.3, told=TOLD):
    """What is said of a chair at (x, 0.05 m, 2 deg) whose camera is truly at `mount`, with prints larger by `scale` and
    marker 1 moved; `told`: standard deviation of each image's rotation [rad]."""
    markers, rng = Markers(CHAIR.camera, DOCK, PlausibilityParameters()), np.random.default_rng(3)
    T = np.linalg.inv(mount.T_base_optical()) @ pose_matrix(inverse([x, 0.05, math.radians(2.0)]))
    for _ in range(images):
        sights = []
        for marker in DOCK.markers:
            place = np.array(marker.position) + (np.array(moved) if marker.id == 1 else 0.0)
            T_optical_marker = T @ marker.T_dock_marker()
            T_optical_marker[:3, 3] = scale * (T[:3, :3] @ place + T[:3, 3]) + NOISE * rng.normal(size=3)
            sights.append(MarkerSight(marker.id, T_optical_marker))
        markers.add([Hypothesis(T, np.diag([1e-6] * 3 + [told**2] * 3))], sights)
    return markers.check()


def test_a_right_installation_is_left_alone() -> None:
    assert judged() is None
    assert judged(x=-3.0) is None


def test_what_perception_cannot_see_anyway_is_left_alone() -> None:
    """A print of 1 %, a mount of 0.5 deg and 10 mm, a marker hung 3 mm aside."""
    mount = CHAIR.camera
    nearly = dataclasses.replace(mount, z=mount.z + 0.01, pitch=math.radians(0.5), roll=math.radians(0.5))
    assert judged(nearly, 1.01, (0.0, 0.003, 0.003)) is None


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"scale": 1.05}, "print size"),
        ({"scale": 0.9}, "print size"),
        ({"moved": (-0.04, 0.0, 0.0)}, "marker [012] is off the line"),
        ({"moved": (0.0, 0.05, 0.0)}, "as far from each other"),
    ],
)
def test_markers_that_contradict_each_other(wrong, text: str) -> None:
    found = judged(**wrong)
    assert found is not None and found.kind is Kind.INCONSISTENT
    assert re.search(text, found.text), found.text


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"pitch": math.radians(3.0)}, "3.0 deg forward"),
        ({"roll": math.radians(-4.0)}, "4.0 deg sideways"),
        ({"z": 0.78}, "too high"),
        ({"z": 0.63}, "too high"),
    ],
)
def test_a_mount_that_is_not_where_it_is_told(wrong, text: str) -> None:
    found = judged(dataclasses.replace(CHAIR.camera, **wrong))
    assert found is not None and found.kind is Kind.INCONSISTENT
    assert text in found.text and "mount" in found.text, found.text


def test_images_that_say_little_of_tilt_do_not_decide_by_their_number() -> None:
    """A single marker of 8 cm 1.7 m away: of a second's images blur and light are the same, and so is their error."""
    mount = dataclasses.replace(CHAIR.camera, pitch=math.radians(6.0))
    assert judged(mount, x=-1.2, told=math.radians(3.5)) is None
    assert judged(mount, x=-1.2, told=math.radians(1.0)) is not None


def test_a_few_images_decide_nothing() -> None:
    assert judged(scale=1.2, images=10) is None


def test_what_is_not_finite_is_left_out() -> None:
    markers = Markers(CHAIR.camera, DOCK, PlausibilityParameters())
    for _ in range(40):
        T = np.full((4, 4), math.nan)
        markers.add([Hypothesis(T, np.eye(6))], [MarkerSight(k, T) for k in range(3)])
    assert markers.check() is None
