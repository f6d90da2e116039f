"""In front of the bay or beside it."""

from dataclasses import replace

import numpy as np
import pytest

from seater_common.geometry import Bay, Chair, Dock, Marker
from seater_nmpc.plan.front import Front

THREE = tuple(Marker(index, 0.15, (0.9, y, 0.7), np.pi) for index, y in enumerate((0.0, 0.35, -0.35)))


@pytest.mark.parametrize("heading", [0.0, 2.0, -1.0])
@pytest.mark.parametrize(
    ("x", "y", "hidden"),
    [(-1.5, 0.0, False), (-3.0, 1.5, False), (-0.75, 1.25, True), (-0.75, -1.25, True), (-0.3, 1.6, True)],
)
def test_beside_the_bay_the_side_wall_hides_the_middle_marker(x: float, y: float, heading: float, hidden: bool) -> None:
    front = Front(Chair(), Dock(markers=THREE))
    assert front.hidden(np.array([x, y, heading])) is hidden


def test_behind_an_open_dock_its_prints_are_hidden() -> None:
    dock = Dock(markers=THREE, bay=Bay(side_wall_length=0.0))
    assert Front(Chair(), dock).hidden(np.array([2.0, 0.5, 0.0]))
    assert not Front(Chair(), dock).hidden(np.array([-0.75, 1.25, 0.0]))


def test_how_far_the_markers_are_from_the_cameras_axis() -> None:
    chair = Chair()
    front = Front(replace(chair, camera=replace(chair.camera, yaw=0.2)), Dock(markers=THREE))
    assert front.aside(np.array([-1.1, 0.0, 0.0])) == pytest.approx(-0.2)
    assert front.aside(np.array([-1.1, 2.0, 3.0])) == pytest.approx(-0.25 * np.pi - 0.2 - 3.0 + 2.0 * np.pi)
