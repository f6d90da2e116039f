"""A perfect unicycle with perfect or noisy images: what the tests close the loop with, without a ROS master."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
import yaml

SOURCES = Path(__file__).resolve().parents[2]
for package in ("seater_nmpc", "seater_common"):
    sys.path.insert(0, str(SOURCES / package / "src"))

import shared_programmes  # noqa: E402

from seater_common.camera_model import CameraModel  # noqa: E402
from seater_common.geometry import Chair, Dock, pose_matrix  # noqa: E402
from seater_common.se2 import arc_step, compose, inverse  # noqa: E402
from seater_common.way_clearance import smallest_clearance  # noqa: E402
from seater_nmpc.control.command import Command  # noqa: E402
from seater_nmpc.control.controller import DockingController  # noqa: E402
from seater_nmpc.observe.measurement import Hypothesis  # noqa: E402
from seater_nmpc.observe.observer import DockObserver  # noqa: E402
from seater_nmpc.observe.odometry.message import Odometry  # noqa: E402
from seater_nmpc.parameters import ControlParameters, PlausibilityParameters, Prediction  # noqa: E402
from seater_nmpc.plan.navigator import Navigator  # noqa: E402
from seater_nmpc.sequence.docking_sequence import DockingSequence  # noqa: E402
from seater_nmpc.sequence.goal.results import Step  # noqa: E402
from seater_nmpc.sequence.vehicle import Vehicle  # noqa: E402

shared_programmes.share()

T_ODOM_DOCK = np.array([1.0, 2.0, 0.7])
CAMERA = CameraModel.from_mapping(yaml.safe_load((SOURCES.parent / "config/cameras/d455.yaml").read_text()))
AT_ONCE = Prediction(command_delay=0.0, motor_lag=0.0)  # what the perfect unicycle makes of a command
NOISE = (0.002, 0.003)  # standard deviations of an image's pose [m, rad]


FINE = {"period": 0.01, "images": 3}  # a World whose faults, or images, come and go within hundredths of a second


def seldom(*values: object) -> object:
    """Values of a test that runs for them with `./seater test --all` only."""
    return pytest.param(*values, marks=pytest.mark.extensive)


def observation(
    chair: Chair, T_base_dock: np.ndarray, noise: tuple[float, float] = NOISE, weight: float = 1.0
) -> Hypothesis:
    """What perception says when it sees the dock at this pose in base_link; covariance of `noise`."""
    T = np.linalg.inv(chair.camera.T_base_optical()) @ pose_matrix(T_base_dock)
    return Hypothesis(T, np.diag([noise[0] ** 2] * 3 + [noise[1] ** 2] * 3), weight)


@dataclass
class World:
    """The chair, its odometry and its camera, around one docking sequence."""

    sequence: DockingSequence
    chair: Chair
    dock: Dock
    truth: np.ndarray  # base_link in the dock's frame
    seen: Callable[[World], bool] = lambda world: True
    contact: Callable[[World], bool | None] = lambda world: None
    odometry_alive: Callable[[World], bool] = lambda world: True
    obeys: bool = True
    moves: Callable[[World, float, float], tuple[float, float]] = lambda world, v, omega: (v, omega)
    measures: Callable[[World, Odometry], Odometry] = lambda world, odometry: odometry
    shows: Callable[[World, list[Hypothesis]], list[Hypothesis]] = lambda world, found: found
    vehicle: Vehicle = field(default_factory=lambda: Vehicle(Chair(), Dock()))
    period: float = 0.025  # of the odometry [s]
    images: int = 2  # messages of the odometry from image to image
    now: float = 10.0
    v: float = 0.0
    omega: float = 0.0
    track: list[np.ndarray] = field(default_factory=list)  # true poses
    commands: list[Command] = field(default_factory=list)
    phases: list[str] = field(default_factory=list)
    noise: np.random.Generator = field(default_factory=lambda: np.random.default_rng(1))

    def tick(self) -> None:
        """One period: drive, odometry; an image where it is time."""
        self.now = round(self.now + self.period, 6)
        if self.obeys and self.commands:
            self.v, self.omega = self.commands[-1].v, self.commands[-1].omega
        self.truth = arc_step(self.truth, *self.moves(self, self.v, self.omega), self.period)
        self.track.append(self.truth)
        if self.odometry_alive(self):
            odometry = Odometry(self.now, compose(T_ODOM_DOCK, self.truth), self.v, self.omega)
            self.sequence.add_odometry(self.vehicle.odometry(self.measures(self, odometry)))
            if round(self.now / self.period) % self.images == 0:
                error = self.noise.normal(size=3) * [NOISE[0], NOISE[0], NOISE[1]]
                found = [observation(self.chair, inverse(self.truth) + error)] if self.seen(self) else []
                self.sequence.add_detections(self.now, self.shows(self, found))

    @property
    def smallest_clearance(self) -> float:
        """Between the footprint and the bay's walls, on the whole way [m]."""
        return smallest_clearance(self.chair, self.dock.bay, self.track)

    def run(self, seconds: float, until: Callable[[Step], bool] = lambda step: False) -> Step:
        """Control cycles every 50 ms until the goal is done, `until` holds or the time is over."""
        step: Step | None = None
        for _ in range(round(seconds / 0.05)):
            for _ in range(round(0.05 / self.period)):
                self.tick()
            step = self.sequence.update(self.now, self.contact(self))
            self.commands.append(self.vehicle.command(step.command))
            if not self.phases or self.phases[-1] != step.phase.name:
                self.phases.append(step.phase.name)
            if step.done or until(step):
                break
        assert step is not None
        return step


@pytest.fixture(scope="session")
def controller() -> DockingController:
    """The controller with its quickest solver, told that the chair obeys at once."""
    return DockingController(
        Chair(), Dock(), replace(ControlParameters(prediction=AT_ONCE), solver="rti"), deterministic=True, camera=CAMERA
    )


@pytest.fixture(scope="session")
def quick_controller() -> DockingController:
    """Sees as far with half the steps: for sequences, which are not about the last millimetre."""
    parameters = replace(ControlParameters(prediction=AT_ONCE), solver="rti", horizon=15, step=0.2)
    return DockingController(Chair(), Dock(), parameters, deterministic=True, camera=CAMERA)


@pytest.fixture(scope="session")
def navigator() -> Navigator:
    """One whose search is made once; a sequence begins anew with it."""
    return Navigator(Chair(), Dock(), ControlParameters(), camera=CAMERA)


@pytest.fixture
def make_world(quick_controller: DockingController, navigator: Navigator) -> Callable[..., World]:
    def make(start: tuple[float, float, float], require_contact: bool = False, **settings: object) -> World:
        from seater_nmpc.parameters import SequenceParameters, Timeouts

        timeouts = settings.pop("timeouts", {})
        changes = settings.pop("sequence", {})
        limits = replace(Timeouts(), **timeouts)  # type: ignore[arg-type]
        parameters = replace(SequenceParameters(), timeouts=limits, **changes)  # type: ignore[arg-type]
        chair, dock = Chair(), settings.pop("dock", Dock())
        quick_controller.forget_chair()
        observer = DockObserver(chair.camera)
        sequence = DockingSequence(
            chair,
            dock,
            quick_controller,
            observer,
            parameters,
            require_contact=require_contact,
            navigator=navigator,
            plausibility=replace(PlausibilityParameters(), **settings.pop("plausibility", {})),  # type: ignore[arg-type]
        )
        truth = np.array([start[0], start[1], np.deg2rad(start[2])])
        return World(sequence, chair, dock, truth, **settings)  # type: ignore[arg-type]

    return make


class Sent(list):
    """What a publisher was given."""

    def publish(self, message: object) -> None:
        self.append(message)


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> Sent:
    """Of the publisher that the test makes."""
    import rospy

    sent = Sent()
    monkeypatch.setattr(rospy, "Publisher", lambda *_, **__: sent)
    return sent
