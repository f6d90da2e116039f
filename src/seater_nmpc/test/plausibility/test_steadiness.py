"""Values of an installation that change as no installation does."""

from __future__ import annotations

import numpy as np

from seater_nmpc.plausibility.installation.steadiness import Steadiness

NOISE = np.array([0.004, 0.004, 0.0005, 0.001])


def by_one(y: float, sd: float):
    """What a filter has found: the camera's y [m] and its standard deviation [m], the rest as before a goal."""
    return np.array([0.0, y, 0.0, 0.0]), np.diag([0.03, sd, 0.03, 0.05]) ** 2


def test_a_camera_that_moves_aside_within_half_a_metre_is_a_floor() -> None:
    """A worn chair in a campaign (seed 3900000, case 48): from 3 to 76 mm, as the sd fell from 26 to 19 mm."""
    watched, before = Steadiness(), [by_one(0.003, 0.026), by_one(0.001, 0.03)]
    watched.add(before)
    assert watched.unlikely(0, by_one(0.020, 0.024), NOISE) is None
    assert watched.unlikely(0, by_one(0.076, 0.019), NOISE) is before
    assert watched.unlikely(1, by_one(0.028, 0.025), NOISE) is None


def test_what_becomes_known_of_a_wrong_camera_is_none() -> None:
    watched = Steadiness()
    watched.add([by_one(0.0, 0.03)])
    assert watched.unlikely(0, by_one(0.08, 0.006), NOISE) is None
