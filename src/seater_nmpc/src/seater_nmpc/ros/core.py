"""The ROS-free core of the docking node, put together from its private parameters."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import rospy

from seater_common.camera_model import CameraModel
from seater_common.files.docks import DockEntry
from seater_common.geometry import Chair, Dock
from seater_common.params import load
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.plausibility.installation.memory import Memory, mark_of
from seater_nmpc.ros.camera import load_camera
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.shadow import Shadow
from seater_nmpc.sequence.vehicle import Vehicle


@dataclass(kw_only=True)
class Core:
    """What the node is wired round. Live parameters replace `given` and `parameters`."""

    dock: Dock
    given: NmpcParameters  # as in the file
    parameters: NmpcParameters  # adjusted to the bay
    camera: CameraModel | None
    lock_step: bool
    vehicle: Vehicle
    controller: DockingController
    observer: DockObserver
    sequence: DockingSequence
    shadow: Shadow | None  # set in shadow mode
    memory: Memory | None  # of what dockings show of the installation; None: not beyond the node's end

    @property
    def chair(self) -> Chair:
        """As it docks: forward."""
        return self.vehicle.chair

    def remember(self) -> None:
        """Keep what the dockings so far have shown."""
        known = self.sequence.knowledge
        if self.memory is None or known.dockings == 0:
            return
        try:
            self.memory.keep(self.dock.name, mark_of(self.chair, self.dock, self.camera), known)
        except OSError as error:
            rospy.logwarn("what the docking has shown of the installation is not kept: %s", error)


class CoreMaker:
    """Makes cores, one for each dock, that differ in nothing but the dock."""

    def __init__(self, *, lock_step: bool) -> None:
        """From ~chair, ~controller, ~camera (the files in config/), ~shadow, ~rectified, ~require_contact and
        ~installation_memory (a file; none or not set: nothing is kept).

        Raises:
            ValueError: a parameter is missing, unknown, of the wrong type or out of range.
        """
        self._lock_step, self._shadow, self._require_contact = lock_step, flag("~shadow"), flag("~require_contact")
        self._chair = load(Chair, rospy.get_param("~chair", None), rospy.resolve_name("~chair"))
        self._given = load(NmpcParameters, rospy.get_param("~controller", None), rospy.resolve_name("~controller"))
        self._camera = load_camera(rectified=flag("~rectified"))
        file = str(rospy.get_param("~installation_memory", "none"))
        self._memory = None if file == "none" or self._shadow else Memory(Path(file).expanduser())

    def make(self, entry: DockEntry) -> Core:
        """For this dock; ready for the first cycle. Raises ValueError: dock and chair do not fit together."""
        dock, camera = entry.dock, self._camera
        vehicle = Vehicle(self._chair, dock)
        chair = vehicle.chair  # from here on it docks forward
        parameters, warnings = check_setup(chair, dock, self._given, camera, {"dock": entry.source})
        for text in warnings:
            rospy.logwarn("%s: %s", dock.name, text)
        controller = DockingController(chair, dock, parameters.control, deterministic=self._lock_step, camera=camera)
        observer = DockObserver(chair.camera, parameters.observer, standing=not self._shadow)
        navigator = Navigator(chair, dock, parameters.control, parameters.planner, camera)
        sequence = DockingSequence(
            chair,
            dock,
            controller,
            observer,
            parameters.sequence,
            require_contact=self._require_contact,
            navigator=navigator,
            plausibility=parameters.plausibility,
        )
        if self._memory is not None:
            sequence.knowledge = self._memory.recall(dock.name, mark_of(chair, dock, camera))
        controller.warm_up()  # so that the first cycle is not late
        if not self._shadow:
            navigator.prepare()
        return Core(
            dock=dock,
            given=self._given,
            parameters=parameters,
            camera=camera,
            lock_step=self._lock_step,
            vehicle=vehicle,
            controller=controller,
            observer=observer,
            sequence=sequence,
            memory=self._memory,
            shadow=Shadow(controller, observer, parameters.sequence.max_blind_time) if self._shadow else None,
        )


def flag(name: str) -> bool:
    """A parameter that is true or false, false where it is not set. Raises ValueError."""
    value = rospy.get_param(name, False)
    if not isinstance(value, bool):
        raise ValueError(f"{rospy.resolve_name(name)}: is {value!r}, must be true or false")
    return value
