"""The ROS-free core of the docking node, put together from its private parameters."""

from __future__ import annotations

from dataclasses import dataclass

import rospy

from seater_common.camera_model import CameraModel
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


def load_core(*, lock_step: bool) -> Core:
    """From ~chair, ~dock, ~controller, ~camera (the files in config/), ~shadow, ~rectified and ~require_contact; ready
    for the first cycle.

    Raises:
        ValueError: a parameter is missing, unknown, of the wrong type or out of range, or two do not fit together.
    """
    chair = load(Chair, rospy.get_param("~chair", None), rospy.resolve_name("~chair"))
    dock = load(Dock, rospy.get_param("~dock", None), rospy.resolve_name("~dock"))
    vehicle = Vehicle(chair, dock)
    chair = vehicle.chair  # from here on it docks forward
    given = load(NmpcParameters, rospy.get_param("~controller", None), rospy.resolve_name("~controller"))
    shadow = flag("~shadow")
    camera = load_camera(rectified=flag("~rectified"))
    parameters, warnings = check_setup(chair, dock, given, camera)
    for text in warnings:
        rospy.logwarn(text)
    controller = DockingController(chair, dock, parameters.control, deterministic=lock_step, camera=camera)
    observer = DockObserver(chair.camera, parameters.observer, standing=not shadow)
    navigator = Navigator(chair, dock, parameters.control, parameters.planner, camera)
    sequence = DockingSequence(
        chair,
        dock,
        controller,
        observer,
        parameters.sequence,
        require_contact=flag("~require_contact"),
        navigator=navigator,
        plausibility=parameters.plausibility,
    )
    controller.warm_up()  # so that the first cycle is not late
    if not shadow:
        navigator.prepare()
    return Core(
        dock=dock,
        given=given,
        parameters=parameters,
        camera=camera,
        lock_step=lock_step,
        vehicle=vehicle,
        controller=controller,
        observer=observer,
        sequence=sequence,
        shadow=Shadow(controller, observer, parameters.sequence.max_blind_time) if shadow else None,
    )


def flag(name: str) -> bool:
    """A parameter that is true or false, false where it is not set. Raises ValueError."""
    value = rospy.get_param(name, False)
    if not isinstance(value, bool):
        raise ValueError(f"{rospy.resolve_name(name)}: is {value!r}, must be true or false")
    return value
