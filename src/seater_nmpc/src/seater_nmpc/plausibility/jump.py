"""Images that show the dock elsewhere from one image to the next, by more than the chair has moved meanwhile.

However much wheels slip, a chair is at most as far from where its odometry has it as they have rolled since. A dock
that is farther off than that in the very next images has jumped in the images: camera, calibration or dock are not what
they were. A chair that stood may have been pushed, which its wheels need not show; it is measured anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import compose, relative, wrap_angle
from seater_nmpc.observe.images import Jump
from seater_nmpc.observe.innovation import Innovation
from seater_nmpc.observe.measurement import sd_of_place
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import PlausibilityParameters

Array = NDArray[np.float64]

_AGREEING = 2  # of the first images, that have to show it
_CERTAIN = 3.0  # standard deviations
_SHARE = 0.5  # of the final error that ends a docking: what jumps by so much more than it may have slipped
_STANDS = 0.001  # [m, rad]
_PER_METRE = 1.0  # [rad/m] that a wheel which spins turns the chair
_BEARING, _AHEAD = 0.015, 0.7  # [rad] of turn, share of the shift: a jump along the line of sight


@dataclass(frozen=True)
class Shift:
    """How far the dock has jumped, seen from the chair."""

    way: float  # [m]
    turn: float  # [rad]
    ahead: float  # [m] of the way; positive: farther away

    @property
    def text(self) -> str:
        """What, and what may be the cause."""
        seen = f"{1e3 * self.way:.0f} mm and {math.degrees(abs(self.turn)):.1f} deg"
        along = abs(self.turn) < _BEARING and abs(self.ahead) > _AHEAD * self.way
        where = (" farther away" if self.ahead > 0.0 else " nearer") if along else ""
        check = (
            "the focal length (camera_info) and the camera's mount" if along else "camera_info and the camera's mount"
        )
        return f"on the way the dock jumped by {seen}{where} in the images: check {check}; or was the dock moved?"


def sudden(jump: Jump, parameters: PlausibilityParameters) -> Shift | None:
    """The jump, if the chair drove meanwhile, and no slip explains it."""
    shifts = [_shift(jump.before, *doubted, parameters) for doubted in jump.doubted]
    found = [shift for shift in shifts if shift is not None]
    return found[0] if len(found) >= _AGREEING else None


def _shift(
    before: Instant, chair: Instant, dock: Array, off: Innovation, parameters: PlausibilityParameters
) -> Shift | None:
    """What one image shows, beyond all that wheels may have slipped since `before`; turning moves the dock, too."""
    p, driven, turned = parameters, abs(chair.driven - before.driven), abs(chair.turned - before.turned)
    if driven + turned < _STANDS:
        return None
    here, there = relative(chair.pose, dock - off.value), relative(chair.pose, dock)
    turn = wrap_angle(float(there[2] - here[2]))
    move = there[:2] - compose([0.0, 0.0, turn], here)[:2]
    way, far, sd_turn = float(np.hypot(*move)), math.hypot(there[0], there[1]), float(off.sd[2])
    shifted = way > _SHARE * p.final_position + driven + _CERTAIN * sd_of_place(off.covariance, far)
    if not shifted and abs(turn) <= _SHARE * p.final_heading + turned + _PER_METRE * driven + _CERTAIN * sd_turn:
        return None
    return Shift(way, turn, float(move @ there[:2]) / max(far, 1e-6))
