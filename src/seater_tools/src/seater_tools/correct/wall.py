"""The back wall of a dock whose markers were measured: no print hangs behind the wall that it hangs on."""

from __future__ import annotations

from collections.abc import Iterable

from seater_common.files.scalars import Path
from seater_common.geometry import Bay

# [m] A wall measured by tape, prints hung 20 mm off, and a dock frame turned by 6 deg with markers 0.35 m beside its
# middle leave so much. Beyond it, it is another mistake, which the doctor names.
MOST = 0.08


def wall_values(bay: Bay, wall: float, markers: Iterable[float]) -> dict[Path, float]:
    """Values for the dock file: the wall, at x = `wall` [m] as far as is known, is not before any marker's x. The
    entrance of the bay stays as far before the wall that is known: side walls become longer by as much."""
    farthest = max(markers, default=wall)
    behind = farthest - wall if 0.0 < farthest - wall <= MOST else 0.0
    values: dict[Path, float] = {("bay", "back_wall_x"): wall + behind}
    if behind > 0.0 and bay.side_wall_length > 0.0:
        values["bay", "side_wall_length"] = bay.side_wall_length + behind
    return values
