"""How far the chair has turned by the images, and by the odometry, over a longer time than image_motion.py looks at.

In a few images a turn on the spot at 0.3 rad/s, as the chair makes it to see where its camera sits, is as little as
what tyres and single images explain; and a chair that stops while images contradict, and goes on, keeps no speed. What
it has turned adds up: the bearing in odom of the markers' middle, seen from where the odometry has the chair, changes
by what the odometry tells too much. Even a flipped pose leaves the bearing right, and a wrong image decides nothing: at
both ends of the time the median of three counts.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import relative, wrap_angle
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction
from seater_nmpc.plausibility.image_motion import CERTAIN, CLOCKS, NEAREST, Shown, doubted, of_one_place, places_of

Array = NDArray[np.float64]

_LONG = 1.5  # [s] of images
_ENDS = 3  # images at each end
_OFF = 0.4  # [s] at `image_turning`: so much less or more than the odometry has it is none
_ASIDE = 0.05  # [m] that castors may push the chair aside meanwhile: near the markers, that looks like a turn


def turn_contradicts(shown: Shown, middle: Array, parameters: PlausibilityParameters) -> Contradiction | None:
    """`middle` (2,): of the dock's markers, in the dock's frame. None, too: too few images, or too near."""
    p, window = parameters, [entry for entry in shown if entry[0].stamp >= shown[-1][0].stamp - _LONG]
    if len(window) < 2 * _ENDS or any(b[0].stamp <= a[0].stamp for a, b in pairwise(window)):
        return None
    ends = [*window[:_ENDS], *window[-_ENDS:]]
    first, last = ends[_ENDS // 2][0], ends[-1 - _ENDS // 2][0]
    places, sds = places_of(of_one_place(ends), middle)
    there = _middle_one(places[_ENDS:])
    ahead, aside, _ = relative(last.pose, [*there, 0.0]).tolist()
    if ahead < NEAREST:
        return None
    off = _bearings(ends, places, there)
    odometry = wrap_angle(float(last.pose[2] - first.pose[2]))
    images = odometry - float(_middle_one(off[_ENDS:]) - _middle_one(off[:_ENDS]))
    most, driven = max(abs(odometry), abs(images)), last.driven - first.driven
    speeds = [chair.omega for chair, _ in window]
    allowed = p.image_turning * _OFF + p.image_share * (most + 2.0 * driven) + CLOCKS * (max(speeds) - min(speeds))
    allowed += (_ASIDE + CERTAIN * float(sds.max())) / math.hypot(ahead, aside)
    if abs(odometry - images) <= allowed:
        return None
    what = f"in {last.stamp - first.stamp:.1f} s the chair turned by {odometry:.2f} rad by its odometry"
    return doubted(f"{what}, by {images:.2f} rad by the images", abs(odometry) < abs(images))


def _middle_one(values: Array) -> Array:
    """Median of an odd number along the first axis: numpy's takes ten times as long for three."""
    return np.asarray(np.sort(values, axis=0)[len(values) // 2])


def _bearings(ends: Shown, places: Array, there: Array) -> Array:
    """[rad] by which each image shows the middle of the markers farther to the left than it is `there`, as seen from
    where the chair was, (n,)."""
    chair = np.array([instant.pose[:2] for instant, _ in ends])
    (x, y), (a, b) = (places - chair).T, (there - chair).T
    return np.asarray(np.arctan2(y * a - x * b, x * a + y * b))
