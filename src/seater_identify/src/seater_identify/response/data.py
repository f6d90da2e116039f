"""What the fit of an axis is given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_identify.response.model import Commands

Array = NDArray[np.float64]


@dataclass(frozen=True)
class AxisData:
    """What the fit sees of one axis, in m or rad."""

    commands: Commands
    other: Array  # (n,) measured mean speed of the other axis, which may leak into this one
    heading: Array  # (n,) [rad] in odom
    begin: Array  # (n,) [s]
    end: Array
    measured: Array  # (n,) mean speed [1/s]
    unit: float  # [1/s] a typical speed of the axis, for the scales of the problem
    # Way from a change of direction until the castors trail, [m] or [rad]. A reversal leaves them pointing ahead, which
    # they hardly feel to be wrong: a turn on the spot needs a quarter.
    settling: float
    trails: bool = False  # castors never trail quite in line with this motion: a turn
