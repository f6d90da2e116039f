"""Judges a run by the true motion alone: docked, touched, comfort. Uses none of the judged code."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from seater_common.geometry import Chair, Dock

Array = NDArray[np.float64]

POSITION, HEADING = 0.010, math.radians(1.0)  # [m, rad] docked
_FAR = (0.020, 2.0)  # [m, deg] a success that is farther off than this misleads
_REST = 0.5  # [s] without motion at the end
_MOVED = (1e-4, 1e-4)  # [m, rad] more than this within that time is motion
_REVERSAL = 0.005  # [m/s] speeds up to this have no direction
_TURNING = 0.02  # [rad/s] nor have these
_LASTING = 0.2  # [s] turning to one side for less than this is no turn
_CREEP = 1e-3  # [m/s, rad/s] up to here a chair is taken to stand while it drives
_CUT_OFF = 5.0  # [Hz] low-pass ahead of acceleration and jerk: 2nd-order Butterworth, forward and backward


@dataclass(frozen=True)
class Motion:
    """What truly happened: times (n,) [s], poses (n, 3) of base_link in the dock's frame, speeds (n, 2)."""

    times: Array
    poses: Array
    speeds: Array

    @property
    def step(self) -> float:
        """[s]"""
        return float(self.times[1] - self.times[0])


def judge(motion: Motion, chair: Chair, dock: Dock, succeeded: bool | None) -> dict[str, Any]:
    """`succeeded`: what the driver says of itself; None: it does not say."""
    x, y, heading = motion.poses[-1]
    error = math.remainder(heading, 2.0 * math.pi)
    standing = stands(motion)
    within = bool(math.hypot(x, y) <= POSITION and abs(error) <= HEADING)
    gap = smallest_gap(motion.poses, chair, dock)
    return {
        "docked": standing and within and succeeded is not False,
        "stands": standing,
        "within": within,
        "touched": gap <= 0.0,
        "smallest_gap_m": gap,
        "position_error_m": math.hypot(x, y),
        "longitudinal_error_m": float(x),
        "lateral_error_m": float(y),
        "heading_error_deg": math.degrees(error),
        "reversals": sign_changes(motion.speeds[:, 0], _REVERSAL),
        "turn_changes": sign_changes(motion.speeds[:, 1], _TURNING, round(_LASTING / motion.step)),
        "moved_m": float(np.hypot(*np.diff(motion.poses[:, :2], axis=0).T).sum()),
        "time_s": _time_until_rest(motion),
        **_comfort(motion),
    }


def is_far(position: float, heading: float) -> bool:
    """Whether a success so far off [m, deg] misleads."""
    return position > _FAR[0] or abs(math.remainder(heading, 360.0)) > _FAR[1]


def stands(motion: Motion) -> bool:
    """Whether the chair did not move at the end."""
    last = motion.poses[motion.times >= motion.times[-1] - _REST - 1e-9]
    shift = np.abs(np.unwrap(last, axis=0, period=2.0 * math.pi) - last[-1]) if len(last) > 1 else np.full((1, 3), 1.0)
    return bool(np.hypot(shift[:, 0], shift[:, 1]).max() <= _MOVED[0] and shift[:, 2].max() <= _MOVED[1])


def sign_changes(values: Array, dead_zone: float, lasting: int = 1) -> int:
    """How often the sign changes, of values beyond the dead zone; what lasts for fewer than `lasting` values does not
    count."""
    signs = np.where(np.abs(values) > dead_zone, np.sign(values), 0.0)
    ends = np.flatnonzero(np.diff(signs)) + 1
    runs = [(float(run[0]), len(run)) for run in np.split(signs, ends)]
    kept = [sign for sign, length in runs if sign != 0.0 and length >= lasting]
    return int(np.count_nonzero(np.diff(kept))) if kept else 0


def smallest_gap(poses: Array, chair: Chair, dock: Dock) -> float:
    """Between the footprint and the bay's walls over all poses [m], along the separating axis; negative: overlap.

    For polygons that are apart it is at most their distance (two corners opposite each other are farther).
    """
    walls = [np.asarray(wall) for wall in dock.bay.outlines()]
    x, y, heading = np.array(poses.T, order="C")  # sines of a strided array may differ in the last bit
    c, s = np.cos(heading), np.sin(heading)
    own = np.array(
        [(x, y) for x in (-chair.length_rear, chair.length_front) for y in (-0.5 * chair.width, 0.5 * chair.width)]
    )
    corners = np.stack(  # (n, 4, 2)
        [
            x[:, None] + np.outer(c, own[:, 0]) - np.outer(s, own[:, 1]),
            y[:, None] + np.outer(s, own[:, 0]) + np.outer(c, own[:, 1]),
        ],
        axis=2,
    )
    return min(float(_separation(corners, wall, c, s).min()) for wall in walls)


def _separation(corners: Array, wall: Array, c: Array, s: Array) -> Array:
    """Largest gap of the projections on the axes of both rectangles, (n,); the wall is upright in the dock's frame.

    Element by element: matrix products of long arrays differ in the last bit from call to call.
    """
    gaps = []
    for x, y in ((c, s), (-s, c), (np.ones_like(c), np.zeros_like(c)), (np.zeros_like(c), np.ones_like(c))):
        own = corners[:, :, 0] * x[:, None] + corners[:, :, 1] * y[:, None]
        its = wall[None, :, 0] * x[:, None] + wall[None, :, 1] * y[:, None]
        gaps.append(np.maximum(its.min(axis=1) - own.max(axis=1), own.min(axis=1) - its.max(axis=1)))
    return np.asarray(np.max(gaps, axis=0))


def _time_until_rest(motion: Motion) -> float:
    """From the start until the last motion that anyone would notice [s]."""
    moving = np.flatnonzero(np.abs(motion.speeds).max(axis=1) > _CREEP)
    return float(motion.times[moving[-1]] - motion.times[0]) if len(moving) else 0.0


def _comfort(motion: Motion) -> dict[str, float]:
    """Peak and root mean square of acceleration and jerk, of the true speeds low-passed at 5 Hz."""
    values = {}
    low_pass = butter(2, _CUT_OFF, fs=1.0 / motion.step, output="sos")
    for name, unit, speed in (("", "m", motion.speeds[:, 0]), ("turning_", "rad", motion.speeds[:, 1])):
        acceleration = np.gradient(sosfiltfilt(low_pass, speed), motion.step)
        for what, signal in (
            (f"acceleration_{unit}_s2", acceleration),
            (f"jerk_{unit}_s3", np.gradient(acceleration, motion.step)),
        ):
            values[f"peak_{name}{what}"] = float(np.abs(signal).max())
            values[f"rms_{name}{what}"] = float(np.sqrt(np.mean(signal**2)))
    return values
