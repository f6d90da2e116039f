"""What odometry and images make of each piece of the drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, planar_pose
from seater_common.se2 import inverse, relative
from seater_tools.doctor.gather.drive import STAND, Piece, Stepper
from seater_tools.doctor.observations import Leg, Move, Sight
from seater_tools.drive.drive import DriveError
from seater_tools.drive.gather import Gatherer

Array = NDArray[np.float64]

FEWEST = 3  # images of a stand


def make_move(
    plan: Sequence[Piece], stepper: Stepper, odometry: Array, sights: Sequence[Sight], chair: Chair, camera: CameraModel
) -> Move:
    """odometry: (n, 6) rows as in Live, of the drive and of STAND [s] after it; `sights` of the same time."""
    gatherer = Gatherer(camera)
    for row in odometry:
        gatherer.odometry(float(row[0]), row[1:4])
    for sight in sights:
        for seen in sight.markers:
            gatherer.pose(sight.stamp, seen.id, seen.size, seen.corners, seen.T, seen.covariance)
    try:
        drive = gatherer.drive()
    except DriveError:
        drive = None
    stands = list(stepper.stands)
    if stepper.stopped and len(odometry):  # the piece that ended early, as far as it went
        stands.append((float(odometry[-1, 0]) - 0.6 * STAND, float(odometry[-1, 0])))
    return Move(_legs(plan, stands, odometry, sights, chair), drive, stepper.stopped)


def _legs(
    plan: Sequence[Piece], stands: Sequence[tuple[float, float]], odometry: Array, sights: Sequence[Sight], chair: Chair
) -> tuple[Leg, ...]:
    measured = [_odometry_at(odometry, end) for _, end in stands]
    seen = [_seen_between(sights, chair, *stand) for stand in stands]
    legs = []
    for i, piece in enumerate(plan[: max(0, len(stands) - 1)]):
        before, after = seen[i], seen[i + 1]
        images = relative(before, after) if before is not None and after is not None else None
        asked = np.array([piece.way, 0.0, piece.turn])
        legs.append(Leg(asked, relative(measured[i], measured[i + 1]), images))
    return tuple(legs)


def _odometry_at(odometry: Array, stamp: float) -> Array:
    return np.asarray(odometry[min(len(odometry) - 1, int(np.searchsorted(odometry[:, 0], stamp))), 1:4])


def _seen_between(sights: Sequence[Sight], chair: Chair, begin: float, end: float) -> Array | None:
    """(3,) base_link in the dock frame, median of the images; None: too few."""
    T_base_optical = chair.camera.T_base_optical()
    poses = [
        inverse(planar_pose(T_base_optical @ sight.docks[0].T_optical_dock))
        for sight in sights
        if sight.docks and begin <= sight.stamp <= end
    ]
    if len(poses) < FEWEST:
        return None
    rows = np.array(poses)
    rows[:, 2] = np.unwrap(rows[:, 2])
    return np.asarray(np.median(rows, axis=0))
