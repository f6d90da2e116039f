"""Where the controller drives to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock

Array = NDArray[np.float64]
Target = str | Sequence[float] | Array  # `dock`, `predock`, or a pose (x, y, heading) in the dock's frame [m, m, rad]


def target_pose(target: Target, dock: Dock) -> Array:
    """(3,) in the dock's frame. Raises ValueError for another name."""
    if isinstance(target, str):
        named = {"dock": [0.0, 0.0, 0.0], "predock": [dock.predock_x, 0.0, 0.0]}
        if target not in named:
            raise ValueError(f"target: is {target!r}, must be one of {', '.join(named)} or a pose")
        return np.array(named[target])
    return np.asarray(target, dtype=float)
