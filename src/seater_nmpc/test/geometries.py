"""Chairs, docks and cameras in a table, and a docking with each on the perfect unicycle with noisy images."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from conftest import World

from seater_common.camera_model import CameraModel
from seater_common.field_of_view import FieldOfView
from seater_common.geometry import Bay, CameraMount, Chair, Dock, Marker, clearance
from seater_common.sight import Sight
from seater_nmpc.checks.setup import check_setup
from seater_nmpc.checks.sight import FOUND_PX
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.plan.navigator import Navigator
from seater_nmpc.sequence.docking_sequence import DockingSequence
from seater_nmpc.sequence.goal.results import Step

PI = math.pi
DETECTOR_PX = 3.0  # what the simulated detector needs around a marker; the controller keeps more
START_LEFT, START_RIGHT = (-2.5, 0.7, -17.0), (-2.2, -0.6, 20.0)


def camera(
    width: int, height: int, f: float, cx: float | None = None, D: tuple[float, ...] = (0.0,) * 5
) -> CameraModel:
    """A camera with its principal point in the middle, or at the column `cx`."""
    K = np.array([[f, 0.0, 0.5 * (width - 1) if cx is None else cx], [0.0, f, 0.5 * (height - 1)], [0.0, 0.0, 1.0]])
    return CameraModel(width, height, "plumb_bob", np.array(D), K, np.eye(3), np.hstack([K, np.zeros((3, 1))]))


D455 = camera(1280, 720, 640.0)
D435 = camera(1280, 720, 910.0)
D435_VGA = camera(640, 480, 600.0)
PI_CAMERA_2 = camera(1640, 1232, 1365.0, D=(0.16, -0.3, 0.0, 0.0, 0.0))  # 62.2 degrees across
PI_CAMERA_1080P = camera(1920, 1080, 1598.0)  # the same camera, 62 degrees across
OFF_CENTRE = camera(1280, 720, 640.0, cx=520.0)
WIDE_BENT = camera(1280, 720, 560.0, D=(-0.12, 0.02, 0.0005, -0.0005, 0.0))

CHAIR = Chair()
NARROW_CHAIR = Chair(length_front=0.65, length_rear=0.25, width=0.52)
BIG_CHAIR = Chair(length_front=0.95, length_rear=0.40, width=0.78, camera=CameraMount(x=0.55))
MID_WHEEL = Chair(length_front=0.50, length_rear=0.55, camera=CameraMount(x=0.2))
FRONT_WHEEL = Chair(length_front=0.25, length_rear=0.80, camera=CameraMount(x=-0.05))


def mounted(chair: Chair = CHAIR, **changes: float) -> Chair:
    """The chair with its camera elsewhere."""
    return replace(chair, camera=replace(chair.camera, **changes))


def dock(chair: Chair = CHAIR, markers: list[Marker] | None = None, **bay: float) -> Dock:
    """The default dock, its back wall as far from the chair's front as for the default chair."""
    wall = chair.length_front + 0.15
    values = {"back_wall_x": wall, "side_wall_length": 0.9, **bay}
    markers = Dock().markers if markers is None else markers
    moved = [replace(m, position=[m.position[0] - 0.9 + wall, *m.position[1:]]) for m in markers]
    side_walls = values["side_wall_length"]
    predock = min(-1.2, wall - side_walls - chair.length_front - 0.45)
    return replace(Dock(), markers=moved, bay=replace(Bay(), **values), predock_x=predock)


ONE = [Marker(0, 0.15, [0.9, 0.0, 0.7], PI)]
ASIDE = [Marker(0, 0.12, [0.9, 0.22, 0.7], PI), Marker(1, 0.12, [0.9, 0.02, 0.7], PI)]
HIGH = [Marker(0, 0.15, [0.9, 0.0, 1.05], PI)]


@dataclass(frozen=True)
class Case:
    """A geometry; `refused`: words of the start-up error, empty when it docks from both starts."""

    name: str
    dock: Dock
    chair: Chair = CHAIR
    camera: CameraModel = D455
    refused: tuple[str, ...] = ()
    starts: tuple[tuple[float, float, float], ...] = (START_LEFT, START_RIGHT)
    parameters: NmpcParameters = field(default_factory=NmpcParameters)


CASES = [
    Case("bay 0.80 m", dock(width=0.80)),
    Case("bay 0.74 m", dock(width=0.74)),
    Case("bay 0.72 m", dock(width=0.72), refused=("dock bay/width", "chair width", "0.736 m")),
    Case("bay 0.60 m", dock(width=0.60), refused=("dock bay/width", "chair width", "0.736 m")),
    Case("deep bay", dock(side_wall_length=1.4)),
    Case("short side walls", dock(side_wall_length=0.4)),
    Case("open dock", dock(side_wall_length=0.0)),
    Case("open dock, one marker, D435", dock(markers=ONE, side_wall_length=0.0), camera=D435),
    Case("one marker", dock(markers=ONE)),
    Case("markers off-centre", dock(markers=ASIDE)),
    Case("chair too long", replace(dock(), bay=Bay(back_wall_x=0.76)), refused=("bay/back_wall_x", "length_front")),
    Case("predock in the bay", replace(dock(), predock_x=-0.5), refused=("predock_x", "length_front")),
    Case("narrow chair", dock(NARROW_CHAIR), NARROW_CHAIR),
    Case("big chair", dock(BIG_CHAIR), BIG_CHAIR),
    Case("mid-wheel chair", dock(MID_WHEEL), MID_WHEEL),
    Case("front-wheel chair", dock(FRONT_WHEEL), FRONT_WHEEL),
    Case("front-wheel chair, bay 0.80 m, D435", dock(FRONT_WHEEL, width=0.80), FRONT_WHEEL, D435),
    Case("D435", dock(), camera=D435),
    Case("D435 at 640 x 480", dock(), camera=D435_VGA),
    Case("Raspberry Pi camera 2", dock(), camera=PI_CAMERA_2),
    Case("Raspberry Pi camera 2, 1080p", dock(), camera=PI_CAMERA_1080P),
    Case("principal point off-centre", dock(), camera=OFF_CENTRE),
    Case("wide lens", dock(), camera=WIDE_BENT),
    Case("camera aside", dock(), mounted(y=0.22)),
    Case("camera aside and turned", dock(), mounted(y=0.25, yaw=-0.25)),
    Case("camera high, looking down", dock(), mounted(z=1.2, pitch=0.5)),
    Case("camera on its side", dock(), mounted(roll=0.5 * PI)),
    Case(
        "high marker, camera level", dock(markers=HIGH), camera=D435, refused=("dock markers", "chair camera", "above")
    ),
    Case("high marker, camera looking up", dock(markers=HIGH), mounted(pitch=-0.45)),
    Case("camera turned away", dock(), mounted(yaw=1.2), D435, refused=("dock markers", "chair camera", "beside")),
    Case("camera looks backward", dock(), mounted(yaw=PI), refused=("dock markers", "chair camera", "behind")),
]

QUICK = ("bay 0.80 m", "open dock, one marker, D435", "front-wheel chair, bay 0.80 m, D435")  # test_geometries.py


def make_world(case: Case, parameters: NmpcParameters, start: tuple[float, float, float]) -> World:
    """With half as many, longer steps in the plan: its last millimetre is tested elsewhere."""
    control = replace(parameters.control, horizon=15, step=0.2)
    controller = DockingController(case.chair, case.dock, control, deterministic=True, camera=case.camera)
    navigator = Navigator(case.chair, case.dock, control, parameters.planner, case.camera)
    observer = DockObserver(case.chair.camera, parameters.observer)
    sequence = DockingSequence(case.chair, case.dock, controller, observer, parameters.sequence, navigator=navigator)
    sight = Sight(case.chair.camera, case.dock, FieldOfView.of(case.camera, DETECTOR_PX))
    truth = np.array([start[0], start[1], math.radians(start[2])])
    return World(sequence, case.chair, case.dock, truth, seen=lambda world: bool(np.any(sight.seen(world.truth))))


def dock_once(case: Case, start: tuple[float, float, float]) -> tuple[World, Step]:
    """Raises ParameterError when the geometry is refused."""
    parameters, _ = check_setup(case.chair, case.dock, case.parameters, case.camera)
    world = make_world(case, parameters, start)
    world.tick()
    world.sequence.start_dock(world.now)
    return world, world.run(120.0)


def random_starts(case: Case, count: int, seed: int = 1) -> list[tuple[float, float, float]]:
    """Ahead of the bay, up to 1.2 m aside, turned away by up to 50 degrees, with a marker in the image that is large
    enough, and nothing nearer than 10 cm."""
    rng, starts = np.random.default_rng(seed), []
    sight = Sight(case.chair.camera, case.dock, FieldOfView.of(case.camera))
    front = case.dock.bay.entrance_x - case.chair.length_front
    while len(starts) < count:
        x, y, heading = front + rng.uniform(-2.5, -0.5), rng.uniform(-1.2, 1.2), rng.uniform(-50.0, 50.0)
        pose = np.array([x, y, math.radians(heading)])
        seen = np.flatnonzero(sight.seen(pose)[0])
        large = any(sight.pixels_across(pose, index, float(case.camera.K[0, 0])) >= FOUND_PX for index in seen)
        if large and clearance(case.chair, case.dock.bay, pose) >= 0.1:
            starts.append((round(x, 3), round(y, 3), round(heading, 1)))
    return starts


def failure(world: World, step: Step) -> str:
    """What is wrong with the end of a run; empty when docked without a touch."""
    if step.result is None or not step.result.success:
        return f"{step.result}"
    error, tolerance = world.truth, world.dock.tolerance
    if math.hypot(error[0], error[1]) > tolerance.position or abs(error[2]) > tolerance.heading:
        return f"ends at {error}"
    return "" if world.smallest_clearance > 0.0 else f"touches: {world.smallest_clearance:.3f} m"
