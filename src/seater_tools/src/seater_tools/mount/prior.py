"""What is known before the drive, each with a standard deviation, and what no drive can show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Dock
from seater_tools.mount.gauge import moved_as_one
from seater_tools.mount.layout import MARKER, Layout

Array = NDArray[np.float64]

MOUNT_SD = (0.1, 0.1, 0.1, 0.2, 0.2, 0.2)  # [m], [rad] of the file: the drive decides
# Scale, heading scale, drift as far as chairs are off; way per turn beyond what follows from the drift; side creep of
# tyres on a slope of 1:48; delay of stamps that are not in the middle of the exposure.
ODOMETRY_SD = (0.03, 0.03, 0.05, 0.0005, 0.002, 0.02)
PLACE_SD = 0.1  # [m] of a marker in the file: the drive decides
YAW_SD = 0.3  # [rad] the same
UPRIGHT_SD = 0.02  # [rad] tilt and roll of a print that was hung by a level
SIZE_SD = 0.02  # of a size that nobody measured: what printers do
READING = 0.00025  # [m] of a ruler, at both ends of a square
TAPE = 0.0005  # [m] of a tape between the same edges of two prints
PRINT_SD = 0.0005  # sizes of one printer, against each other
TRACK = 0.56  # [m] between the driven wheels of a usual chair
HELD = 1e-5  # [m], [rad] of what is held (gauge.py): nothing pulls at it


@dataclass(frozen=True)
class Lengths:
    """What was measured by hand; without any of it nothing says how long a metre is but printer and wheels.

    bar: sd of a factor common to all sizes of the file, which a measured bar corrected (`seater sheets`); None: not so
    sides: id of a marker to the side of its black square [m], by a ruler
    distances: ids of two markers and the distance of their centres [m], by a tape
    """

    bar: float | None = None
    sides: Mapping[int, float] = field(default_factory=dict)
    distances: tuple[tuple[int, int, float], ...] = ()

    @property
    def known(self) -> bool:
        """Whether anything was measured."""
        return self.bar is not None or bool(self.sides) or bool(self.distances)


class Prior:
    """White residuals of the state less what is known."""

    def __init__(self, layout: Layout, dock: Dock, lengths: Lengths, start: Array, track: float = TRACK) -> None:
        self._layout, self._start, self._track = layout, start.copy(), track
        markers = {marker.id: marker for marker in dock.markers}
        files = np.array([markers[id].size for id in layout.ids])
        self._log_size = np.zeros(len(files))
        individual = np.full(len(files), SIZE_SD if lengths.bar is None else PRINT_SD)
        common = lengths.bar or 0.0
        covariance = np.full((len(files), len(files)), common**2) + np.diag(individual**2)
        for i, id in enumerate(layout.ids):
            if id in lengths.sides:
                self._log_size[i] = np.log(lengths.sides[id] / files[i])
                covariance[i, :] = covariance[:, i] = 0.0
                covariance[i, i] = (READING / lengths.sides[id]) ** 2
        row = {id: i for i, id in enumerate(layout.ids)}
        self._distances = [(row[a], row[b], length) for a, b, length in lengths.distances if a in row and b in row]
        self._whiten_sizes = np.linalg.inv(np.linalg.cholesky(covariance))

    def residuals(self, state: Array) -> Array:
        """(12 + lens + 7 markers + 4 + distances,)."""
        layout = self._layout
        moved = state - self._start
        odometry = layout.odometry(state).copy()
        # Wheels whose radii differ by d make both: drift = d / track, way per turn = -d track / 4.
        odometry[3] += 0.25 * self._track**2 * odometry[2]
        markers = layout.markers(moved)
        white = [layout.mount(moved) / MOUNT_SD, odometry / ODOMETRY_SD, layout.lens_off(state)]
        white.append((markers[:, :3] / PLACE_SD).ravel())
        white += [markers[:, 3] / YAW_SD, (markers[:, 4:6] / UPRIGHT_SD).ravel()]
        white.append(self._whiten_sizes @ (markers[:, 6] - self._log_size))
        held = moved_as_one(layout.markers(self._start)[:, :3], markers[:, :4]) / HELD
        places = layout.markers(state)[:, :3]
        off = [float(np.linalg.norm(places[a] - places[b])) - length for a, b, length in self._distances]
        return np.concatenate([*white, held, np.array(off) / TAPE])

    @property
    def count(self) -> int:
        return 12 + self._layout.lens + len(MARKER) * len(self._layout.ids) + 4 + len(self._distances)
