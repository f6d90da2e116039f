"""Watch a simulated installation in lock-step: plant, rendered images, the compiled perception and gate."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
import seater_safety
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load
from seater_nmpc.observe.measurement import Hypothesis
from seater_sim.loop.simulator import SimulatedImage, Simulator
from seater_tools.doctor.gather.drive import STAND, Stepper, pieces
from seater_tools.doctor.gather.legs import make_move
from seater_tools.doctor.gather.watcher import Watcher
from seater_tools.doctor.observations import GateSeen, MarkerSeen, Move, Observations, Sight
from seater_tools.doctor.trial.scene import Scene
from seater_tools.trial.eyes import make_tracker

Array = NDArray[np.float64]

WATCHED = 3.0  # [s] standing
PERIOD = 0.05  # [s] of commands
LONGEST = 60.0  # [s] of the drive
WAY, TURN = 0.3, math.radians(20.0)
ODOMETRY_DELAY = 0.01  # [s] from stamp to arrival


class Watch:
    """One installation. Same scene: same observations, to the bit."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._watcher = scene, Watcher()
        self._rng = np.random.default_rng([scene.seed, 15])
        self._simulator = Simulator(
            scene.simulator, scene.chair, scene.dock, scene.camera, scene.start, seed=scene.seed
        )
        self._perception = _perception(scene)
        self._gate = _gate(scene)
        self._stepper: Stepper | None = None

    def observe(self) -> Observations:
        """Stand, and drive where the scene says so."""
        scene, begin = self._scene, self._now
        scene.tamper.gate(self._gate, begin)
        self._hear_info()
        while self._now < begin + WATCHED:
            self._step()
        base = dataclasses.replace(scene.live, duration=WATCHED, told=scene.told, T_base_optical=scene.T_base_optical)
        live = self._watcher.live(base, scene.traffic, _dock(scene))
        if scene.drive:
            live = dataclasses.replace(live, move=self._drive())
        return Observations(scene.files, scene.machine, live)

    @property
    def _now(self) -> float:
        return self._simulator.time_ns / 1e9

    def _drive(self) -> Move:
        chair = load(Chair, self._scene.files["chair"].values, "chair")
        plan, begin, sent = pieces(WAY, TURN), self._now, -math.inf
        self._stepper = Stepper(plan, chair.limits, PERIOD)
        end = begin + LONGEST
        while self._now < end:
            self._step()
            if self._stepper.over and end > self._now + STAND:
                end = self._now + STAND
            if self._now >= sent + PERIOD - 1e-9 and self._now > begin + 0.1:
                self._simulator.command(*self._scene.tamper.command(*self._stepper.command(self._now)))
                sent = self._now
        rows, sights = self._watcher.since(begin)
        return make_move(plan, self._stepper, rows, sights, chair, self._watcher.newest.info or self._scene.camera)

    def _step(self) -> None:
        due, watcher = self._simulator.step(), self._watcher
        if due.odometry is not None:
            sample = due.odometry
            row = self._scene.tamper.odometry(np.array([sample.time_ns / 1e9, *sample.pose, sample.v, sample.omega]))
            if row is not None:
                self._hear_odometry(row)
        for image in due.images:
            self._hear_image(image)
        if due.tick:
            v, omega = self._scene.tamper.joystick(self._rng)
            watcher.joystick(v, omega)
            self._gate.output(self._now)
            state = str(self._gate.state).rpartition(".")[2]
            watcher.newest.gate = GateSeen(state, "", state == "EMERGENCY_STOP")
            watcher.newest.contact = self._scene.tamper.contact(due.truth.contact)
            watcher.arrived("gate_state", self._now, self._now)

    def _hear_odometry(self, row: Array) -> None:
        self._watcher.arrived("odom", float(row[0]), self._now + ODOMETRY_DELAY)
        self._watcher.newest.frames = self._watcher.newest.frames if any(self._watcher.newest.frames) else FRAMES
        self._watcher.odometry(tuple(row.tolist()))
        if self._stepper is not None:
            self._stepper.odometry(float(row[0]), row[1:4], self._now)

    def _hear_image(self, image: SimulatedImage) -> None:
        pixels = self._scene.tamper.image(np.asarray(image.render(), dtype=np.uint8))
        if pixels is None:
            return
        stamp = self._scene.tamper.image_stamp(image.stamp_ns / 1e9)
        watcher = self._watcher
        for role in ("image", "camera_info"):
            watcher.arrived(role, stamp, self._now)
        watcher.image(stamp, pixels)
        if self._perception is None or pixels.shape != (self._perception.height, self._perception.width):
            return
        watcher.arrived("detections", stamp, self._now)
        watcher.sight(_sight(stamp, self._perception.tracker.detect(pixels)))

    def _hear_info(self) -> None:
        newest = self._watcher.newest
        newest.image_frame = "camera_color_optical_frame"
        try:
            newest.info = CameraModel.from_mapping(self._scene.info, "camera_info")
        except ParameterError as error:
            newest.info_error = str(error)


FRAMES = ("odom", "base_link")


@dataclasses.dataclass(frozen=True)
class _Perception:
    tracker: sp.DockTracker
    width: int
    height: int


def _perception(scene: Scene) -> _Perception | None:
    """As the nodelet, told the files and camera_info; None: it would not start."""
    try:
        info = CameraModel.from_mapping(scene.info, "camera_info")
        told = scene.told
        tracker = make_tracker(info, told["dock"], told["perception"], told["chair"]["camera"])
    except (ParameterError, ValueError, TypeError, KeyError):
        return None
    return _Perception(tracker, info.width, info.height)


def _gate(scene: Scene) -> seater_safety.VelocityGate:
    """Of the files that the scene began with: faults of the gate's own files are those of a program that never ran."""
    limits = dataclasses.asdict(scene.chair.limits)
    safety = {k: float(v) for k, v in (scene.told["safety"] or {}).items()}
    footprint = {key: getattr(scene.chair, key) for key in ("length_front", "length_rear", "width")}
    known = {entry["key"]: entry["default"] for entry in seater_safety.describe_parameters()}
    values = known | {k: v for k, v in (safety | limits | footprint).items() if k in known}
    return seater_safety.VelocityGate(**{k: float(v) for k, v in values.items()})


def _sight(stamp: float, found: sp.DetectionResult) -> Sight:
    markers = tuple(
        MarkerSeen(m.id, m.size, np.asarray(m.corners, dtype=float).reshape(4, 2), m.hypotheses[0].pose, m.covariance)
        for m in found.markers
    )
    return Sight(stamp, markers, tuple(Hypothesis(d.pose, d.covariance, d.weight) for d in found.dock))


def _dock(scene: Scene) -> Dock | None:
    try:
        return load(Dock, scene.files["dock"].values, "dock")
    except ParameterError:
        return None
