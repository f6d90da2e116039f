"""The simulated chair in its world, without ROS. It owns the time; `step` says what falls due.

simulator = Simulator(settings, Chair(), Dock(), CameraModel.load(path), [-1.5, 0.3, 0])
while True:
    due = simulator.step()
    for taken in due.images:
        image = taken.render()          # only here is anything drawn
    if due.odometry is not None:
        simulator.command(v, omega)
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_sim.camera.camera import Camera
from seater_sim.chair.interface import OdometrySample
from seater_sim.chair.make import make_plant
from seater_sim.loop.arrival import Arrivals
from seater_sim.ranging.sensor import RangeSensor
from seater_sim.ranging.taken import Ranges, SimulatedRange
from seater_sim.settings import NANOSECONDS, NO_SENSOR, WHEELCHAIR, SimulatorSettings, to_ns
from seater_sim.world.contact import ChargingContact, CollisionMonitor, Walls
from seater_sim.world.events import NAN, NAN_CAMERA_INFO, OFF, Event, Schedule, WorldState
from seater_sim.world.walkers import Walkers

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """How things really are."""

    time_ns: int
    pose: Array  # (x [m], y [m], heading [rad]) of base_link in the true dock frame
    v: float  # [m/s]
    omega: float  # [rad/s]
    contact: bool  # the charging contact is closed
    touching: bool  # runs into a wall or an obstacle
    collisions: int  # so often it has begun to, or to touch somebody who walks
    min_clearance: float  # smallest distance from walls and obstacles of the run so far [m]


@dataclass(frozen=True)
class SimulatedImage:
    """An image that has been taken; `render` draws it."""

    index: int
    stamp_ns: int  # the middle of the exposure
    pose: Array  # true pose of base_link in the dock frame at the stamp
    v: float
    omega: float
    covered: frozenset[int]
    mode: str  # see events: "good", "nan", "nan_camera_info"
    seed: int
    camera: Camera | None

    @property
    def encoding(self) -> str:
        """As in sensor_msgs/Image."""
        if self.mode == NAN or self.camera is None:
            return "32FC1"
        return self.camera.settings.encoding

    @property
    def camera_info_valid(self) -> bool:
        """Whether the camera_info that goes with it is in order."""
        return self.mode != NAN_CAMERA_INFO

    def render(self) -> NDArray[np.uint8] | NDArray[np.float32]:
        """(height, width) uint8 for mono8, (height, width, 3) uint8 for rgb8, (height, width) float32 NaN for 32FC1.

        Raises:
            RuntimeError: the simulator was made without a camera model.
        """
        if self.camera is None:
            raise RuntimeError("this simulator has no camera model, so its images cannot be drawn")
        if self.mode == NAN:
            return np.full((self.camera.model.height, self.camera.model.width), np.nan, np.float32)
        return self.camera.render(self.pose, self.v, self.omega, covered=self.covered, seed=self.seed, index=self.index)


@dataclass(frozen=True)
class Due:
    """What a step brings, in the order in which it goes out."""

    time_ns: int
    tick: bool  # an odometry period has ended, whether there is a message or not
    odometry: OdometrySample | None
    truth: Truth
    images: list[SimulatedImage]  # delivered now, taken `latency` ago
    events: list[Event]  # that happened at this step
    ranges: list[SimulatedRange]  # of the sensor of obstacles, as the images


class Simulator:
    """Time, plant, odometry, camera, contact and walls of one run. Same arguments and commands: same run, to the
    bit."""

    def __init__(
        self,
        settings: SimulatorSettings,
        chair: Chair,
        dock: Dock,
        camera_model: CameraModel | None,
        start: ArrayLike,
        *,
        seed: int = 0,
        events: Iterable[Event] = (),
        camera: Camera | None = None,
    ) -> None:
        """Args:
        chair: the one that is there; who controls it may be told another.
        camera_model: None for runs that never draw an image.
        start: pose (x [m], y [m], heading [rad]) of base_link in the dock frame.
        seed: of odometry errors and image noise, >= 0.
        events: what happens during the run.
        camera: takes the place of one made from `camera_model`, so that many runs can share it.

        Raises ValueError when the start pose is not finite or overlaps a wall, or the dock's dictionary has no such
        marker.
        """
        self.settings = settings
        self.seed = seed
        self._start_ns = to_ns(settings.start_time)
        self._step_ns = to_ns(settings.step)
        self._plant, self._odometry = make_plant(settings.plant, settings.odometry, chair.limits, start, seed)
        late = settings.plant.wheelchair.odometry.arrival_jitter if settings.plant.kind == WHEELCHAIR else 0.0
        self._arrivals = Arrivals(to_ns(late), seed)
        self._contact = ChargingContact(settings.contact, dock)
        obstacles = [obstacle.polygon() for obstacle in settings.obstacles]
        reach = float(np.max(np.linalg.norm(chair.corners(), axis=1)))
        self._collision = CollisionMonitor(Walls(chair, dock.bay, obstacles), self._plant.pose, reach)
        if self._collision.clearance < 0.0:
            raise ValueError(f"start: at {list(map(float, self._plant.pose))} the chair overlaps a wall or an obstacle")
        self.camera = camera
        if camera is None and camera_model is not None:
            self.camera = Camera(camera_model, chair.camera, dock, settings.camera, settings.scene, settings.obstacles)
        sensor = None
        if settings.ranging.kind != NO_SENSOR:
            sensor = RangeSensor(settings, chair.camera, dock, camera_model)
        self.range_sensor = sensor
        self._ranges = Ranges(sensor, seed, self._start_ns)
        self._walkers = Walkers(chair, settings.walkers, reach)
        self.world = WorldState(frozenset(marker.id for marker in dock.markers))
        self._schedule = Schedule(list(events))
        self._images_taken = 0
        self._on_the_way: deque[SimulatedImage] = deque()
        self._way = self._turn = 0.0  # since the last odometry
        self._contact.update(self._plant.pose, 0.0, 0.0)

    @property
    def time_ns(self) -> int:
        """Simulated time [ns]."""
        return self._start_ns + self._plant.time_ns

    @property
    def refused(self) -> int:
        """Commands so far that were not finite and counted as zero."""
        return self._plant.refused

    @property
    def walkers(self) -> Array:
        """Where those are who walk, (n, 2) [m] in the dock frame."""
        return self._walkers.positions

    @property
    def truth(self) -> Truth:
        """How things are now."""
        plant, collision = self._plant, self._collision
        return Truth(
            self.time_ns,
            plant.pose.copy(),
            plant.v,
            plant.omega,
            self._contact.closed,
            collision.touching,
            collision.collisions + self._walkers.touches,
            collision.smallest,
        )

    def command(self, v: float, omega: float) -> bool:
        """A velocity command arrives now [m/s, rad/s]; False when it is not finite (it then counts as zero)."""
        return self._plant.command(v, omega)

    def power(self, on: bool) -> None:
        """The motors' power, from now on. Without it the brakes stop the chair, and commands are lost."""
        self._plant.power(on)

    def halt(self) -> None:
        """The chair stands and all commands are forgotten: the end of a run."""
        self._plant.halt()

    def step(self) -> Due:
        """Advance by one time step."""
        plant, before_ns = self._plant, self.time_ns
        plant.step(self._step_ns)
        motion = plant.motion
        if self._collision.blocks(plant.pose, abs(motion.way) + abs(motion.side), motion.turn):
            plant.block()
        self._way += plant.motion.way
        self._turn += plant.motion.turn
        elapsed = plant.time_ns / NANOSECONDS
        events = self._schedule.take_due(elapsed, math.hypot(plant.pose[0], plant.pose[1]))
        for event in events:
            self.world.apply(event)
        self._contact.update(plant.pose, plant.v, plant.omega)
        self._walkers.update(plant.pose, elapsed)
        self._take_images(before_ns)
        ranges = self._ranges.step(self.time_ns, plant.pose, self._walkers.positions)
        tick = plant.time_ns % to_ns(self.settings.odometry.period) == 0
        if tick:
            self._measure_odometry()
        odometry = self._arrivals.receive(self.time_ns)
        return Due(self.time_ns, tick, odometry, self.truth, self._delivered(), events, ranges)

    def first_odometry(self) -> OdometrySample:
        """What the wheels say before the first step: where the odometry begins. To be asked at most once."""
        return self._odometry.update(0.0, 0.0, to_ns(self.settings.odometry.period), self.time_ns)

    def _measure_odometry(self) -> None:
        period = to_ns(self.settings.odometry.period)
        sample = self._odometry.update(self._way, self._turn, period, self.time_ns)
        self._way = self._turn = 0.0
        if self.world.odometry:
            self._arrivals.send(sample)

    def _take_images(self, before_ns: int) -> None:
        """Take every image whose exposure has its middle within the step that has just been made."""
        while True:
            index = self._images_taken + 1
            stamp = self._start_ns + round(index * NANOSECONDS / self.settings.camera.rate)
            if stamp > self.time_ns:
                return
            self._images_taken = index
            if self.world.images == OFF:
                continue
            pose = self._plant.pose_within((stamp - before_ns) / self._step_ns)
            world, plant = self.world, self._plant
            self._on_the_way.append(
                SimulatedImage(
                    index, stamp, pose, plant.v, plant.omega, world.covered, world.images, self.seed, self.camera
                )
            )

    def _delivered(self) -> list[SimulatedImage]:
        latency = to_ns(self.settings.camera.latency)
        images = []
        while self._on_the_way and self._on_the_way[0].stamp_ns + latency <= self.time_ns:
            images.append(self._on_the_way.popleft())
        return images
