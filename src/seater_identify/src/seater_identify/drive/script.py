"""Which moves excite what.

Straights at three speeds there and back: delay, lag, gain and ramp of the speed, odometry scale and drift. A whole turn
each way, each at a place of its own: the same of the turning rate, and the heading scale, because the dock is seen
before and after a whole turn. Slow rises from zero, each after a move the same way so that the castors already trail:
deadbands.
"""

from __future__ import annotations

import math

from seater_common.geometry import Chair, Limits
from seater_identify.drive.moves import OMEGA, Creep, Move, Pause, Travel, V
from seater_identify.settings import DriveSettings, IdentifySettings

LOW_SHARE = 1.0 / 40.0  # of the end of a slow rise, where it begins
# [s] for which a slow rise in turning goes on once the chair moves: whether the deadband is taken off every command
# shows at several times the deadband; from there on it looks like a smaller gain.
RISE_ON = 4.5
EDGE = 0.05  # [m] kept free between the farthest planned footprint and the area's edge
SHORTEST = 0.5  # [m] of straight way; on less the chair never reaches a steady speed


class AreaError(ValueError):
    """The free area is too small for this chair."""


def make_script(settings: IdentifySettings, chair: Chair) -> list[Move]:
    """The drive, one and a half minutes. Raises AreaError with the sizes that would do."""
    way = straight_way(settings, chair)
    drive, limits = settings.drive, chair.limits
    forward = min(drive.v, limits.v_max)
    backward = min(drive.v, limits.v_reverse_max)
    turning = min(drive.omega, limits.omega_max)
    pause = Pause(drive.pause)
    half, turn = 0.5 * way, 2.0 * math.pi
    first, second = _turning_places(chair, way)
    moves: list[Move] = [Pause(1.5)]
    for move in (
        Travel(V, half, 0.6 * forward),
        Travel(V, half, forward),
        _creep(drive, V, 1.0, limits),
        Travel(V, -way, backward),
        _creep(drive, V, -1.0, limits),
        Travel(V, way, forward),
        Travel(V, first - way, 0.6 * backward),
        Travel(OMEGA, 0.25 * turn, 0.6 * turning),
        _creep(drive, OMEGA, 1.0, limits),
        Travel(OMEGA, 0.75 * turn, turning),
        Travel(V, second - first, 0.6 * forward),
        Travel(OMEGA, -0.25 * turn, 0.6 * turning),
        _creep(drive, OMEGA, -1.0, limits),
        Travel(OMEGA, -0.75 * turn, turning),
        Travel(V, -second, backward),
    ):
        moves += [move, pause]
    return [*moves, Pause(0.5)]


def straight_way(settings: IdentifySettings, chair: Chair) -> float:
    """[m] there and back that fits into the area, and whose middle leaves room to turn. Raises AreaError."""
    area, radius = settings.area, _turning_radius(chair)
    way = settings.drive.way
    while way > SHORTEST and _length(chair, way) > area.length:
        way -= 0.01
    length, width = _length(chair, SHORTEST), 2.0 * (radius + EDGE)
    if _length(chair, way) > area.length or area.width < width:
        raise AreaError(
            f"area: is {area.length} m x {area.width} m, must be at least {length + 0.005:.2f} m x "
            f"{width + 0.005:.2f} m for a chair that needs {2.0 * radius:.2f} m to turn"
        )
    return way


def origin_in_area(settings: IdentifySettings, chair: Chair) -> float:
    """[m] of the axle ahead of the area's rear edge at the start: what is not needed is left free at both ends."""
    way = straight_way(settings, chair)
    return _origin(chair, way) + 0.5 * (settings.area.length - _length(chair, way))


def _turning_places(chair: Chair, way: float) -> tuple[float, float]:
    """[m] ahead of the start where the chair turns to the left, and to the right: as far apart as the area allows that
    it needs for the way and to turn in its middle, since a slippery patch under one of them would look like motors that
    turn the chair too slowly."""
    radius, half = _turning_radius(chair), 0.5 * way
    return min(half, radius - chair.length_rear), max(half, way + chair.length_front - radius)


def _origin(chair: Chair, way: float) -> float:
    return EDGE + _turning_radius(chair) - _turning_places(chair, way)[0]


def _length(chair: Chair, way: float) -> float:
    """[m] of the area that a drive needs."""
    return _origin(chair, way) + _turning_places(chair, way)[1] + _turning_radius(chair) + EDGE


def _turning_radius(chair: Chair) -> float:
    return math.hypot(max(chair.length_front, chair.length_rear), 0.5 * chair.width)


def _creep(drive: DriveSettings, axis: int, sign: float, limits: Limits) -> Creep:
    high = (
        min(drive.creep_v, limits.v_max, limits.v_reverse_max)
        if axis == V
        else min(drive.creep_omega, limits.omega_max)
    )
    moved, after = (0.008, 0.8) if axis == V else (0.02, RISE_ON)
    return Creep(axis, sign * LOW_SHARE * high, sign * high, drive.creep_double, moved, after)
