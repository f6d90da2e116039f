"""What disturbs the speed of an axis, as functions of its undisturbed answer; the fit takes a share of each."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from seater_identify.response.fit import AxisData

Array = NDArray[np.float64]

# Standard deviations that a share has before anything was measured. asymmetry: difference of the gains of both ways;
# slope and castors: fraction of the typical speed; cross: of the other axis' speed; droop: of the gain, over the
# recording.
PRIOR_SD = {"asymmetry": 0.01, "slope": 0.03, "cross": 0.03, "droop": 0.005}
# Ways since the chair began to move so at which the push of the castors is free, in between it is interpolated;
# typical speed x [s].
SWING = (0.0, 0.1, 0.25, 0.5, 0.9, 1.5)
CASTOR_SD = 0.08
PRIOR_SD |= {f"castor_{knot}": CASTOR_SD for knot in SWING[:-1]}


def disturbances(data: AxisData) -> dict[str, Callable[[Array], Array]]:
    """Name to function: from the undisturbed speed (n,) to the disturbing one (n,)."""
    duration = data.end - data.begin
    middle = 0.5 * (data.begin + data.end)
    age = (middle - middle.mean()) / max(float(np.ptp(middle)), 1e-9)

    def slope(answer: Array) -> Array:
        return data.unit * np.tanh(np.abs(answer) / (0.05 * data.unit))

    def castor(index: int) -> Callable[[Array], Array]:
        knots, height = np.array(SWING) * data.unit, np.eye(len(SWING))[index]

        def push(answer: Array) -> Array:
            way = way_since_change(answer, data.other, duration, data.unit)
            return data.unit * np.tanh(answer / (0.05 * data.unit)) * np.interp(way, knots, height)

        return push

    plain: dict[str, Callable[[Array], Array]] = {
        "asymmetry": np.abs,
        "slope": slope,
        "cross": lambda answer: data.other,
        "droop": lambda answer: answer * age,
    }
    return plain | {f"castor_{knot}": castor(index) for index, knot in enumerate(SWING[:-1])}


def way_since_change(speed: Array, other: Array, duration: Array, unit: float) -> Array:
    """Way (n,) of this axis since the chair began to move so: since it changed its direction, or moved otherwise."""
    signs = np.where(np.abs(speed) > 0.01 * unit, np.sign(speed), np.where(np.abs(other) > 0.1 * unit, 2.0, 0.0))
    moves = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(signs)), -1))  # the last one that was a motion
    kinds = np.where(moves >= 0, signs[moves], 2.0)
    steps = np.abs(speed) * duration
    total = np.cumsum(steps)
    began = np.where(kinds != np.append(2.0, kinds[:-1]), total - steps, 0.0)
    return np.asarray(total - np.maximum.accumulate(began))
