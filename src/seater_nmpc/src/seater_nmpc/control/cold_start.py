"""Trajectories that a cold solve begins with: an optimisation finds the minimum next to where it begins.

Standing where the chair is suits a chair near the target. From far away the nearest minimum may be to back off with the
dock going out of view; a chair that drives towards the target begins next to the right one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Limits
from seater_common.se2 import arc_step

Array = NDArray[np.float64]

_BRISK = 0.5  # of the largest speeds
_NEAR = 0.5  # [m] from the target within which standing is guess enough
_CARROT = 0.6  # of the distance along the target's axis: where on that axis the chair heads for
_STEERING = 1.5  # [rad/s per rad] of the direction to it


def standing(state: Array, steps: int) -> Array:
    """(steps + 1, 5): x, y [m], heading [rad] in the target's frame, v [m/s], omega [rad/s]; at rest at `state`."""
    states = np.repeat(state[None, :], steps + 1, axis=0)
    states[:, 3:] = 0.0
    return states


def heading_for_target(state: Array, lengths: Array, limits: Limits) -> Array | None:
    """The same of a chair that drives forward to the target's axis and along it (pure pursuit; Coulter 1992).

    `lengths` (N,): of the steps [s]. None where that is no way to get there: near to it, beyond it, or turned away.
    """
    x, y, heading = (float(value) for value in state[:3])
    if x > -_NEAR or abs(math.remainder(math.atan2(-y, -x) - heading, 2.0 * math.pi)) > 0.5 * math.pi:
        return None
    states, pose, v = np.zeros((len(lengths) + 1, 5)), np.array(state[:3], dtype=float), float(state[3])
    states[0] = [x, y, heading, 0.0, 0.0]
    for i, length in enumerate(lengths.tolist()):
        to_carrot = math.atan2(-pose[1], -_CARROT * min(float(pose[0]), -0.1))
        off = math.remainder(to_carrot - heading, 2.0 * math.pi)
        omega = min(max(_STEERING * off, -_BRISK * limits.omega_max), _BRISK * limits.omega_max)
        # As far away as it still is, it can stop in time.
        fast = min(_BRISK * limits.v_max, math.sqrt(limits.a_max * max(0.0, -float(pose[0]))))
        v = min(max(fast, v - limits.a_max * length), v + limits.a_max * length)
        heading += omega * length  # unwound, as the solver counts it
        pose = np.append(arc_step(pose, v, omega, length)[:2], heading)
        states[i + 1] = [*pose, v, omega]
    return states
