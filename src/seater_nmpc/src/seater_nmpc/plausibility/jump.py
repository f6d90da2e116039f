"""Images that show the dock elsewhere from one image to the next, by more than the chair has moved meanwhile.

However much wheels slip, a chair is at most as far from where its odometry has it as they have rolled since. A dock
that is farther off than that in the very next images has jumped in the images: camera, calibration or dock are not what
they were. Where an image leaves two poses open, going from one to the other is no jump. A chair that stood may have
been pushed, which its wheels need not show; it is measured anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from seater_common.se2 import compose, relative, wrap_angle
from seater_nmpc.observe.images import Doubted, Jump
from seater_nmpc.observe.measurement import Measurement, sd_of_place
from seater_nmpc.observe.odometry.instant import Instant
from seater_nmpc.parameters import PlausibilityParameters

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
    shifts = [_shown_by(image, jump, parameters) for image in jump.doubted]
    found = [shift for shift in shifts if shift is not None]
    return found[0] if len(found) >= _AGREEING else None


def _shown_by(image: Doubted, jump: Jump, parameters: PlausibilityParameters) -> Shift | None:
    """What one image shows: nothing where any of the poses that it leaves open is one that was open before."""
    common = image.expected.covariance  # and more: its drift is that of all
    known = [image.expected, *(replace(m, covariance=m.covariance + common) for m in jump.left_open)]
    shifts = [_shift(jump.before, image.chair, was, now, parameters) for now in image.shown for was in known]
    return None if None in shifts else shifts[0]


def _shift(
    before: Instant, chair: Instant, was: Measurement, now: Measurement, parameters: PlausibilityParameters
) -> Shift | None:
    """From where the dock was to where it is, beyond all that wheels may have slipped since `before`; turning moves the
    dock, too."""
    p, driven, turned = parameters, abs(chair.driven - before.driven), abs(chair.turned - before.turned)
    if driven + turned < _STANDS:
        return None
    covariance = was.covariance + now.covariance
    here, there = relative(chair.pose, was.pose), relative(chair.pose, now.pose)
    turn = wrap_angle(float(there[2] - here[2]))
    move = there[:2] - compose([0.0, 0.0, turn], here)[:2]
    way, far, sd_turn = float(np.hypot(*move)), math.hypot(there[0], there[1]), math.sqrt(covariance[2, 2])
    shifted = way > _SHARE * p.final_position + driven + _CERTAIN * sd_of_place(covariance, far)
    if not shifted and abs(turn) <= _SHARE * p.final_heading + turned + _PER_METRE * driven + _CERTAIN * sd_turn:
        return None
    return Shift(way, turn, float(move @ there[:2]) / max(far, 1e-6))
