"""Round the corner of the bay, where driving straight for the dock ends beside it.

The optimisation looks some seconds ahead: from beside the bay it drives up to the wall's corner, and there it sees no
way on. A chair that gets nowhere backs off, and drives along a planned way until the rest is a matter of driving
straight in. (The docking sequence, which gives the controller poses to drive to, plans its ways itself; it also turns a
chair round that looks away from the dock, which this does not.)
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_nmpc.control.target import Target, target_pose
from seater_nmpc.drive.progress import Progress
from seater_nmpc.parameters import ControlParameters, SequenceParameters
from seater_nmpc.plan.back_off import BackOff
from seater_nmpc.plan.corridor import Corridor
from seater_nmpc.plan.navigator import Navigator

Array = NDArray[np.float64]


class WayRound:
    """Ask it for the target in each cycle; poses (3,) of base_link in the dock's frame."""

    def __init__(self, chair: Chair, dock: Dock, control: ControlParameters, camera: CameraModel | None) -> None:
        """Arguments as of DockingController. Nothing is searched before a chair gets stuck, which then takes some
        tenths of a second."""
        defaults = SequenceParameters()
        self._dock, self._walls = dock, control.walls
        self._corridor = Corridor(chair, dock, defaults)
        self._progress, self._back_off = Progress(defaults.stall_time), BackOff(defaults.predock_position)
        self._parts = (chair, dock, control, camera)
        self._planned = False  # whether it drives along a planned way
        self.begins = False  # whether it has got stuck in this cycle: the plan that led there is of no use

    @cached_property
    def _navigator(self) -> Navigator:
        chair, dock, control, camera = self._parts
        return Navigator(chair, dock, control, camera=camera)

    def restart(self) -> None:
        """Another docking begins."""
        self._planned = False
        self._progress.restart()
        self._back_off.forget()

    def towards(self, target: Target, stamp: float, pose: Array, obstacles: list[Array]) -> Array:
        """Where this cycle drives to (3,), from `pose` at `stamp` [s]; another target than the dock, and one in free
        space, is taken as it is. `obstacles`: convex outlines (n, 2) [m]. Raises ValueError for an unknown name."""
        wanted, self.begins = target_pose(target, self._dock), False
        if not self._walls or not isinstance(target, str) or target != "dock":
            return wanted
        first = self._first(stamp, pose, obstacles)
        return wanted if first is None else first

    def _first(self, stamp: float, pose: Array, obstacles: list[Array]) -> Array | None:
        """Where to drive to before the dock; None: straight to the dock."""
        if self._corridor.contains(pose):
            self.restart()
            return None
        if not self._back_off.goes_on and self._progress.stuck(stamp, pose):
            self._plan(obstacles)
            self._back_off.begin(stamp, pose)
            self.begins = True
        target = self._back_off.target(stamp, pose)
        if target is not None:
            self._progress.restart()
            return target
        if not self._planned:
            return None
        self._navigator.see(obstacles)
        return self._navigator.target(pose)

    def _plan(self, obstacles: list[Array]) -> None:
        self._planned = True
        self._navigator.see(obstacles)
        self._navigator.give_room()
