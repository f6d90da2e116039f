"""Speeds by the images against those by the odometry.

The middle of the dock's markers stands still. Where images show it drifting in odom at (u along the chair's direction,
w across it), the odometry is wrong by domega = w / x and dv = u + domega y, where (x, y) is the middle of the markers
seen from the chair: the chair's turning shows in the bearing, which even a flipped pose leaves right. A single wrong
image decides nothing: the drift counts as the smallest that is left when any one of the images is taken away.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import relative, wrap_angles
from seater_nmpc.observe.measurement import Measurement, between
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction, Kind

Array = NDArray[np.float64]
Shown = Sequence[tuple[Instant, list[Measurement]]]

_WINDOW = 0.4  # [s] of images
_FEWEST, _LONGEST = 5, 1.2  # images; [s] that they may take, else the camera is too slow for this
NEAREST = 0.3  # [m] of the markers ahead: nearer, their bearing says little of turning
CERTAIN = 3.0  # standard deviations
# [s] by which the stamps of odometry and images may differ (a driver that stamps what it receives): while the chair
# speeds up or turns in, each then shows another moment.
CLOCKS = 0.15
# [m, rad] off the line that an image may be, beyond its own standard deviations: speeds change. Two flipped images in a
# row, whose place is nearly right, looked like wheels that spin: the heading tells.
_ON_THE_LINE = (0.015, 0.1)


@dataclass(frozen=True)
class ImageSpeeds:
    """Means over the window."""

    stamp: float  # of the newest image
    odometry: tuple[float, float]  # v [m/s], omega [rad/s]
    images: tuple[float, float]
    sd: tuple[float, float]  # of the difference
    later: tuple[float, float] = (0.0, 0.0)  # by how much speeds change within what clocks may differ by


def speeds_by_images(shown: Shown, middle: Array, fewest: int = _FEWEST) -> ImageSpeeds | None:
    """`middle` (2,): of the dock's markers, in the dock's frame. None: fewer than `fewest` images, too slow a camera,
    images that do not agree, or that did not come in the order of their times."""
    window = _window(shown, fewest)
    if len(window) < fewest or not 0.0 < window[-1][0].stamp - window[0][0].stamp <= _LONGEST:
        return None
    last = window[-1][0]
    best = of_one_place(window)
    times = np.array([instant.stamp for instant, _ in window])
    places, sds = places_of(best, middle)
    x, y, _ = relative(last.pose, [*places[-1], 0.0]).tolist()
    slopes = _slopes(times, places, sds, best)
    if slopes is None or x < NEAREST:
        return None
    c, s = math.cos(last.pose[2]), math.sin(last.pose[2])
    u, w = slopes @ [c, s], slopes @ [-s, c]
    domega = w / x
    difference = _smallest(u + domega * y), _smallest(domega)
    odometry = _by_odometry(window[0][0], last)
    sd = float(sds.mean()) / math.sqrt(float(np.sum((times - times.mean()) ** 2)))
    return ImageSpeeds(
        stamp=last.stamp,
        odometry=odometry,
        images=(odometry[0] - difference[0], odometry[1] - difference[1]),
        sd=(sd * math.hypot(1.0, y / x), sd / x),
        later=_later(window),
    )


def of_one_place(shown: Shown) -> list[Measurement]:
    """Of the poses that each image leaves open the nearest to the likeliest of the newest: two places of a marker at
    the side of the dock, by turns, would be a motion."""
    newest = max(shown[-1][1], key=lambda measurement: measurement.weight)
    return [
        offered[0] if len(offered) == 1 else min(offered, key=lambda measurement: between(measurement, newest))
        for _, offered in shown
    ]


def contradiction(speeds: ImageSpeeds, parameters: PlausibilityParameters) -> Contradiction | None:
    """Whether one of them moves much more than the other."""
    p = parameters
    v, omega = (max(abs(a), abs(b)) for a, b in zip(speeds.odometry, speeds.images, strict=True))
    allowed = (
        p.image_speed + p.image_share * v + CERTAIN * speeds.sd[0] + speeds.later[0],
        # tyres that slip on one side by that share turn a chair of usual width by as much per metre
        p.image_turning + p.image_share * (omega + 2.0 * v) + CERTAIN * speeds.sd[1] + speeds.later[1],
    )
    for axis, name, unit in ((0, "drives", "m/s"), (1, "turns", "rad/s")):
        odometry, images = speeds.odometry[axis], speeds.images[axis]
        if abs(odometry - images) <= allowed[axis]:
            continue
        what = f"the chair {name} at {odometry:.2f} {unit} by its odometry, at {images:.2f} {unit} by the images"
        return doubted(what, abs(odometry) < abs(images))
    return None


def doubted(what: str, less: bool) -> Contradiction:
    """What odometry and images say; `less`: the odometry measures less."""
    if less:
        return Contradiction(Kind.ODOMETRY_WRONG, f"{what} (odometry frozen, or an encoder failed?)")
    return Contradiction(
        Kind.WHEELS_SLIP, f"{what} (wheels spinning, something in the way, or images that do not change?)"
    )


def _window(shown: Shown, fewest: int) -> Shown:
    """The newest images: those of the last _WINDOW, more where these are too few."""
    newest = shown[-1][0].stamp if shown else 0.0
    recent = [entry for entry in shown if entry[0].stamp >= newest - _WINDOW - 1e-6]
    return recent if len(recent) >= fewest else list(shown)[-fewest:]


def _by_odometry(first: Instant, last: Instant) -> tuple[float, float]:
    """Mean speeds between two instants, by its poses."""
    x, y, turn = relative(first.pose, last.pose).tolist()
    duration = last.stamp - first.stamp
    return math.copysign(math.hypot(x, y), x) / duration, turn / duration


def _later(window: Shown) -> tuple[float, float]:
    """By how much the speeds of the odometry change within CLOCKS, as they change most in the window."""
    share = min(1.0, CLOCKS / (window[-1][0].stamp - window[0][0].stamp))
    speeds = np.array([(instant.v, instant.omega) for instant, _ in window])
    v, omega = (share * np.ptp(speeds, axis=0)).tolist()
    return v, omega


def places_of(best: list[Measurement], middle: Array) -> tuple[Array, Array]:
    """Where each measurement shows the middle (2,) of the markers in odom, (n, 2), and how certainly, (n,) [m]."""
    poses, cosines, sines = _poses(best)
    turns = np.stack([cosines, sines, -sines, cosines], axis=1).reshape(-1, 2, 2)  # rotations, transposed
    return (middle @ turns) + poses[:, :2], _sds(best, cosines, sines, middle)


def _poses(best: list[Measurement]) -> tuple[Array, Array, Array]:
    """Poses (n, 3), and cosine and sine of their headings, (n,)."""
    poses = np.array([one.pose for one in best])
    headings = poses[:, 2].tolist()
    return poses, np.array([math.cos(one) for one in headings]), np.array([math.sin(one) for one in headings])


def _sds(best: list[Measurement], c: Array, s: Array, middle: Array) -> Array:
    """Standard deviation of where each measurement shows the middle of the markers, the larger one, (n,) [m]; `c` and
    `s`: cosine and sine of its heading."""
    J = np.zeros((len(best), 2, 3))
    J[:, 0, 0] = J[:, 1, 1] = 1.0
    J[:, 0, 2], J[:, 1, 2] = -s * middle[0] - c * middle[1], c * middle[0] - s * middle[1]
    P = J @ np.array([one.covariance for one in best]) @ J.transpose(0, 2, 1)
    mean, half = 0.5 * (P[:, 0, 0] + P[:, 1, 1]), 0.5 * (P[:, 0, 0] - P[:, 1, 1])
    return np.asarray(np.sqrt(mean + np.hypot(half, P[:, 0, 1])))  # of the larger eigenvalue


def _slopes(times: Array, places: Array, sds: Array, best: list[Measurement]) -> Array | None:
    """Of the lines through all images but one, (n, 2) [m/s], as far as they fit those, in place and heading; None where
    none does. A plainly wrong image is left out, and of those that fit the smallest slope counts."""
    n = len(times)
    headings = wrap_angles(np.array([one.pose[2] for one in best]) - best[-1].pose[2])
    places = np.column_stack([places, headings])
    allowed = CERTAIN * np.column_stack([sds, [math.sqrt(one.covariance[2, 2]) for one in best]]) + _ON_THE_LINE
    kept = _all_but_one(n)
    t, there = times[kept], places[kept]  # (n, n - 1) and (n, n - 1, 3)
    t, there = t - t.mean(axis=1)[:, None], there - there.mean(axis=1)[:, None, :]
    slopes = (t[:, None, :] @ there)[:, 0, :] / (t[:, None, :] @ t[:, :, None])[:, 0, :]
    left = there - t[:, :, None] * slopes[:, None, :]
    off = np.stack([np.hypot(left[..., 0], left[..., 1]), np.abs(left[..., 2])], axis=2)
    fits = np.all(off <= allowed[kept], axis=(1, 2))
    return slopes[fits, :2] if fits.any() else None


@functools.cache
def _all_but_one(n: int) -> NDArray[np.intp]:
    """Indices (n, n - 1): row i has all but the i-th."""
    return np.nonzero(~np.eye(n, dtype=bool))[1].reshape(n, n - 1)


def _smallest(values: Array) -> float:
    """The one nearest to zero; zero where their signs differ."""
    low, high = float(values.min()), float(values.max())
    return low if low > 0.0 else high if high < 0.0 else 0.0
