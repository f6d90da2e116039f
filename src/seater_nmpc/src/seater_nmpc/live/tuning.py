"""Other weights and tolerances for a controller and a sequence that are in use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from seater_common.camera_model import CameraModel
from seater_common.geometry import Dock
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.live.offered import changed
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.vehicle import Vehicle


class Tunable(Protocol):
    """What is tuned: the core of the docking node."""

    dock: Dock
    given: NmpcParameters  # as in the file
    parameters: NmpcParameters  # adjusted to the bay
    camera: CameraModel | None
    lock_step: bool
    vehicle: Vehicle
    controller: DockingController
    sequence: DockingSequence


@dataclass(frozen=True)
class Prepared:
    """Changes that fit, ready to be made."""

    core: Tunable
    given: NmpcParameters
    adjusted: NmpcParameters
    warnings: list[str]
    controller: DockingController | None  # plans with other weights; None: they have not changed

    def make(self) -> None:
        """Between two goals, in the thread that the core belongs to. Raises ValueError: a goal is active."""
        self.core.sequence.tune(self.adjusted.sequence)
        self.core.given, self.core.parameters = self.given, self.adjusted
        if self.controller is not None:
            self.core.controller.plan_like(self.controller)


def prepare(core: Tunable, values: Mapping[str, float | int]) -> Prepared:
    """In any thread; changes nothing. Other weights take about a second: they are another optimisation problem.

    Raises:
        ParameterError: a value is impossible, or does not fit to chair, dock and camera.
    """
    given, chair = changed(core.given, values), core.vehicle.chair
    adjusted, warnings = check_setup(chair, core.dock, given, core.camera)
    if adjusted.control == core.parameters.control:
        return Prepared(core, given, adjusted, warnings, None)
    controller = DockingController(chair, core.dock, adjusted.control, deterministic=core.lock_step, camera=core.camera)
    controller.warm_up()
    return Prepared(core, given, adjusted, warnings, controller)
