"""The ROS-free core of the docking node, put together from its private parameters."""

from __future__ import annotations

from dataclasses import dataclass

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

    @property
    def chair(self) -> Chair:
        """As it docks: forward."""
        return self.vehicle.chair


class CoreMaker:
    """Makes cores, one for each dock, that differ in nothing but the dock."""

    def __init__(self, *, lock_step: bool) -> None:
        """From ~chair, ~controller, ~camera (the files in config/), ~shadow, ~rectified and ~require_contact.

        Raises:
            ValueError: a parameter is missing, unknown, of the wrong type or out of range.
        """
        self._lock_step, self._shadow, self._require_contact = lock_step, flag("~shadow"), flag("~require_contact")
        self._chair = load(Chair, rospy.get_param("~chair", None), rospy.resolve_name("~chair"))
        self._given = load(NmpcParameters, rospy.get_param("~controller", None), rospy.resolve_name("~controller"))
        self._camera = load_camera(rectified=flag("~rectified"))

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
            shadow=Shadow(controller, observer, parameters.sequence.max_blind_time) if self._shadow else None,
        )


def flag(name: str) -> bool:
    """A parameter that is true or false, false where it is not set. Raises ValueError."""
    value = rospy.get_param(name, False)
    if not isinstance(value, bool):
        raise ValueError(f"{rospy.resolve_name(name)}: is {value!r}, must be true or false")
    return value
