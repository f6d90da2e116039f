"""Polygons that come at run time, kept clear of by separating lines that are given with each instance."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair
from seater_common.separation import footprints, nearest, separating_lines
from seater_nmpc.ocp.constraints.interface import AreaConstraint, Slack, Stage
from seater_nmpc.parameters import ControlParameters
from seater_nmpc.programme import StageProgramme

Array = NDArray[np.float64]

_NO_LINE = -1.0  # [m] offset, beside a normal of zero, of a line that constrains nothing
_SIZE = 7  # parameters of a line: normal, offset, and the two corners of the footprint (in base_link) nearest to it


class ObstacleConstraint(AreaConstraint[Array]):
    """Each stage has `max_obstacles` lines; the two corners nearest to a line stay ahead of it by the margin.

    The lines are parameters, not variables, and a plan that keeps them is clear of the polygons.
    """

    slack = Slack.AREA

    def __init__(self, chair: Chair, parameters: ControlParameters, programme: StageProgramme) -> None:
        super().__init__()
        self._corners, self._margin = chair.corners(), parameters.margin
        self._stages, self._slots = parameters.horizon, parameters.max_obstacles
        self._p, self._where = programme.parameter("lines", _SIZE * self._slots * self._stages)

    def margins(self, stage: Stage) -> list[ca.SX]:
        """See AreaConstraint."""
        pose, c, s = stage.pose, ca.cos(stage.pose[2]), ca.sin(stage.pose[2])
        margins = []
        for slot in range(self._slots):
            at = _SIZE * (stage.index * self._slots + slot)
            line = self._p[at : at + _SIZE]
            for corner in (line[3:5], line[5:7]):
                x, y = pose[0] + c * corner[0] - s * corner[1], pose[1] + s * corner[0] + c * corner[1]
                margins.append(line[0] * x + line[1] * y - line[2] - self._margin)
        return margins

    def set_instance(self, area: Array | None, p: Array, lower: Array, upper: Array) -> None:
        """See AreaConstraint. `area`: what `lines` returned; None: no obstacles."""
        p[self._where] = np.ravel(self._no_lines() if area is None else area)

    def lines(self, polygons: list[Array], states: Array) -> Array:
        """Parameters of the lines that separate the footprint, at the states 1..N, from the nearest polygons.

        `polygons`: convex, anticlockwise, (n, 2) each, in the frame of `states` (N + 1, >= 3). Shape (N, slots, 7).
        """
        result = self._no_lines()
        if not polygons or self._slots == 0:
            return result
        shapes = footprints(self._corners, states[1:])
        lines = nearest(separating_lines(shapes, polygons), self._slots)
        count = lines.offsets.shape[1]
        ahead = lines.normals @ shapes.transpose(0, 2, 1)  # (N, count, 4)
        two = np.argsort(ahead, axis=2, kind="stable")[:, :, :2]
        result[:, :count, :2], result[:, :count, 2] = lines.normals, lines.offsets
        result[:, :count, 3:] = self._corners[two].reshape(len(shapes), count, 4)
        return result

    def _no_lines(self) -> Array:
        """Lines that constrain nothing, (N, slots, 7)."""
        lines = np.zeros((self._stages, self._slots, _SIZE))
        lines[:, :, 2] = _NO_LINE
        return lines
