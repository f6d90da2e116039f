"""What contradicts what."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Kind(Enum):
    """Named as the result codes of seater_msgs/Dock.action."""

    BLOCKED = "asked to drive, but stands"
    RUNAWAY = "moves though it is not asked to"
    WRONG_DIRECTION = "drives the other way than asked for"
    ODOMETRY_WRONG = "the odometry measures less than the images show"
    WHEELS_SLIP = "the wheels turn, but by the images the chair does not move so"
    INCONSISTENT = "images, odometry and installation do not fit together"


@dataclass(frozen=True)
class Contradiction:
    """One that is certain enough to stop for."""

    kind: Kind
    text: str  # what, with numbers, and what may be the cause
    on_the_spot: bool = False  # BLOCKED in a turn on the spot, of which few images say little
