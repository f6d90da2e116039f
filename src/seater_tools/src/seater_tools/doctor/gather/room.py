"""Whether the drive of `--move` has room, by where the images have the dock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock, clearance, planar_pose
from seater_common.se2 import compose, inverse
from seater_tools.doctor.gather.drive import ASTRAY, PROBE
from seater_tools.doctor.observations import Live

Array = NDArray[np.float64]

LEAST = 0.10  # [m] between the footprint and the bay's walls all along; ASTRAY is in it
STEPS = 9  # headings of the turn that are looked at


def room_for(live: Live, chair: Chair, dock: Dock, way: float, turn: float) -> str:
    """Why there is none; empty: there is, or the dock is not seen and nobody but the person can say."""
    T = chair.camera.T_base_optical()
    poses = [inverse(planar_pose(T @ sight.docks[0].T_optical_dock)) for sight in live.sights if sight.docks]
    if not poses:
        return ""
    pose = np.median(np.array(poses), axis=0)
    turned = [compose(compose(pose, [PROBE, 0.0, 0.0]), [0.0, 0.0, angle]) for angle in np.linspace(-turn, turn, STEPS)]
    ahead = [compose(pose, [way + ASTRAY[0], 0.0, 0.0])]
    gap = min(clearance(chair, dock.bay, place) for place in (*turned, *ahead))
    if gap < LEAST:
        return f"it would leave {gap:.2f} m to the bay's walls, {LEAST:.2f} m are needed: stand farther from the dock"
    return ""
