"""What disturbs the speed of an axis, as functions of its undisturbed answer; the fit takes a share of each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_identify.response.data import AxisData

Array = NDArray[np.float64]

# Standard deviations that a share has before anything was measured. asymmetry: difference of the gains of both ways;
# slope (speed that gravity adds at the headings 0 and 90 deg) and castors: fraction of the typical speed; cross: of the
# other axis' speed; droop: of the gain, over the recording.
PRIOR_SD = {"asymmetry": 0.01, "slope_0": 0.03, "slope_90": 0.03, "cross": 0.03, "droop": 0.005}
# Ways since the chair began to move so at which the push of the castors is free, in between it is interpolated; shares
# of the way in which they settle.
SWING = (0.0, 0.07, 0.17, 0.33, 0.6, 1.0)
CASTOR_SD = 0.08
# Castors never trail quite in line while the chair turns: their tyres go on to be swivelled, at any rate alike.
# 2 push trail^2 / (ahead * distance of the pivot) of seater_sim.chair.castors: up to 0.01 rad/s.
TRAILING_SD = 0.015
PRIOR_SD |= {f"castor_{knot}": CASTOR_SD for knot in SWING[:-1]} | {f"castor_{SWING[-1]}": TRAILING_SD}


class Disturbances:
    """Of one axis."""

    def __init__(self, data: AxisData, trailing: bool) -> None:
        """`trailing`: with the one whose share has TRAILING_SD."""
        self._data, self._duration = data, data.end - data.begin
        middle = 0.5 * (data.begin + data.end)
        self._age = (middle - middle.mean()) / max(float(np.ptp(middle)), 1e-9)
        self._pulls = [data.unit * direction for direction in (np.cos(data.heading), np.sin(data.heading))]
        self._ways, self._heights = np.array(SWING) * data.settling, np.eye(len(SWING))
        self._knots = SWING if trailing else SWING[:-1]
        self.names = ("asymmetry", "slope_0", "slope_90", "cross", "droop", *(f"castor_{knot}" for knot in self._knots))

    def columns(self, answer: Array) -> list[Array]:
        """In the order of `names`: from the undisturbed speed (n,) the disturbing ones, each (n,)."""
        data = self._data
        # While the motors drive, whichever axis moves; a chair at rest is held.
        drives = np.tanh(np.hypot(answer, data.other) / (0.05 * data.unit))
        sense = data.unit * np.tanh(answer / (0.05 * data.unit))
        way = way_since_change(answer, data.other, self._duration, data.unit)
        castors = [sense * np.interp(way, self._ways, height) for height in self._heights[: len(self._knots)]]
        slopes = [pull * drives for pull in self._pulls]
        return [np.abs(answer), *slopes, data.other, answer * self._age, *castors]


def way_since_change(speed: Array, other: Array, duration: Array, unit: float) -> Array:
    """Way (n,) of this axis since the chair began to move so: since it changed its direction, or moved otherwise."""
    signs = np.where(np.abs(speed) > 0.01 * unit, np.sign(speed), np.where(np.abs(other) > 0.1 * unit, 2.0, 0.0))
    moves = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(signs)), -1))  # the last one that was a motion
    kinds = np.where(moves >= 0, signs[moves], 2.0)
    steps = np.abs(speed) * duration
    total = np.cumsum(steps)
    began = np.where(kinds != np.append(2.0, kinds[:-1]), total - steps, 0.0)
    return np.asarray(total - np.maximum.accumulate(began))
