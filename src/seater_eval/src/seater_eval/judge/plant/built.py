"""One chair on one floor, drawn from the effects: what stays the same during a run."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from seater_eval.judge.plant.effects import Effects

TRACK = 0.56  # [m] between the driven wheels, as the odometry believes
_PATCHES = 14  # on the floor ahead of the dock, of which they cover about a quarter


@dataclass(frozen=True)
class Patch:
    """A slippery disc on the floor, in the dock's frame."""

    x: float  # [m]
    y: float  # [m]
    radius: float  # [m]
    slip: float  # of a wheel on it, instead of the constant slip


@dataclass(frozen=True)
class Built:
    """What a user cannot read off the chair; `told.py` tells what identification could find."""

    lag_v: float  # [s]
    lag_omega: float  # [s]
    slip: tuple[float, float]  # left, right
    radius: tuple[float, float]  # relative error of the left and right wheel's radius
    track: float  # relative error
    strength: tuple[float, float]  # speed of the left and right wheel over that asked for
    slope: tuple[float, float]  # sine of the slope along x and y of the dock's frame; uphill is positive
    patches: tuple[Patch, ...]
    castor_side: float  # [rad] direction of the castors beside straight ahead: which way round they swing


def draw_built(effects: Effects, rng: np.random.Generator) -> Built:
    """Every number is drawn whether its effect is on or not, so that one effect does not change another's draw."""
    drive, floor = effects.drive, effects.floor
    lag_v, lag_omega = rng.uniform(0.0, 1.0, 2) * (drive.lag[1] - drive.lag[0]) + drive.lag[0]
    slip = floor.slip * rng.uniform()
    uneven = 0.1 * rng.uniform(-1.0, 1.0)  # the wheels' loads differ a little
    off = rng.uniform(2.0 / 3.0, 1.0, 3) * rng.choice([-1.0, 1.0], 3)
    weak = floor.weaker * rng.uniform()
    left = bool(rng.integers(2))
    uphill = rng.uniform(-math.pi, math.pi)
    side = rng.uniform(0.02, 0.1) * rng.choice([-1.0, 1.0])
    return Built(
        lag_v=float(lag_v),
        lag_omega=float(lag_omega),
        slip=(slip * (1.0 + uneven), slip * (1.0 - uneven)),
        radius=(floor.radius * float(off[0]), floor.radius * float(off[1])),
        track=floor.track * float(off[2]),
        strength=(1.0 - weak * left, 1.0 - weak * (not left)),
        slope=(math.sin(floor.slope) * math.cos(uphill), math.sin(floor.slope) * math.sin(uphill)),
        patches=tuple(_patch(floor.patch_slip, rng) for _ in range(_PATCHES)) if floor.patch_slip > 0.0 else (),
        castor_side=float(side),
    )


def _patch(largest: float, rng: np.random.Generator) -> Patch:
    """More of them on the axis than beside it, as there the chair drives."""
    x = rng.uniform(-3.5, 0.4)
    y = rng.uniform(-1.0, 1.0) * (0.4 + 0.3 * max(0.0, -x))
    return Patch(float(x), float(y), float(rng.uniform(0.12, 0.4)), float(largest * rng.uniform(0.5, 1.0)))
