"""What is to be done with a chair at rest near the dock: leave it there, move it a little, or try again."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import inverse
from seater_nmpc.observe.measurement import Measurement, combine, in_frame
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import SequenceParameters

Array = NDArray[np.float64]
Fresh = list[tuple[Instant, Measurement]]

_BEYOND = 0.5  # of `release_position`, from which on it is driven back; a few millimetres turn no castor round
_DOUBT = 3.0  # standard deviations
_LEAST_DOUBT = np.array([0.001, 0.001, 0.002])  # [m, m, rad]: less is not worth another move
_LARGEST_TURN = 0.12  # [rad] beyond that a turn on the spot may bring a corner to a wall


class Correction(Enum):
    """What is to be done."""

    STAY = 0
    TURN = 1
    MOVE = 2  # forward or backward
    AGAIN = 3

    @property
    def is_move(self) -> bool:
        """Whether it is a small move."""
        return self in (Correction.TURN, Correction.MOVE)


def standing_dock(fresh: Fresh) -> Array:
    """The dock in base_link (3,): mean of images taken while the chair stood, whatever drift its odometry has."""
    return standing_measurement(fresh).pose


def standing_measurement(fresh: Fresh) -> Measurement:
    """The same with its covariance."""
    return combine([in_frame(inverse(instant.pose), measurement) for instant, measurement in fresh])


def is_off(x: float, parameters: SequenceParameters) -> bool:
    """Whether a chair at `x` [m] of the dock's axis is worth a push; back only for more, as that is a reversal."""
    return x < -parameters.hold_position or x > _BEYOND * parameters.release_position


def surely(error: Array, covariance: Array) -> Array:
    """What of the error (3,) is beyond doubt, given its covariance (3, 3); zero where that is nothing."""
    doubt = np.maximum(_DOUBT * np.sqrt(np.diag(covariance)), _LEAST_DOUBT)
    return np.asarray(np.sign(error) * np.maximum(np.abs(error) - doubt, 0.0))


def judge(
    error: Array, moves: int, parameters: SequenceParameters, *, turn: bool = True, move: bool = True
) -> Correction:
    """Of a standing chair at `error` (3,) from the dock, after so many small moves.

    `turn`, `move`: whether that would be of use.

    Sideways only a new attempt helps; heading and distance can be mended on the spot.
    """
    p = parameters
    x, y, heading = (abs(float(value)) for value in error)
    if y > p.release_position or heading > _LARGEST_TURN:
        return Correction.AGAIN
    # Castors that a turn has swung out push on the same way when it drives on; on a slope the chair rolls on.
    off = error[0] < -p.hold_position or error[0] > p.release_position
    if turn and moves < p.max_moves and heading > p.hold_heading and not (off and move and moves > 0):
        return Correction.TURN
    near = math.hypot(x, y) <= p.release_position
    if move and moves < p.max_moves and (is_off(float(error[0]), p) or (not near and error[0] > 0.0)):
        return Correction.MOVE
    inside = near and heading <= p.release_heading
    return Correction.STAY if inside else Correction.AGAIN
