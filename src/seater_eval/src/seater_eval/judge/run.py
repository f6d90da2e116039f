"""One docking on the independent chair."""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.se2 import compose, inverse
from seater_eval.judge.cases import Row, draw_start
from seater_eval.judge.drivers import ClassDriver, Driver, SequenceDriver
from seater_eval.judge.parts import kept, load_files
from seater_eval.judge.plant.built import draw_built
from seater_eval.judge.plant.camera import DockCamera
from seater_eval.judge.plant.chair import STEP, IndependentChair
from seater_eval.judge.plant.encoders import WheelOdometry
from seater_eval.judge.plant.faults import Injector
from seater_eval.judge.told import told_parameters
from seater_eval.judge.verdict import Motion, is_far, judge, smallest_gap
from seater_nmpc.parameters import ControlParameters, NmpcParameters
from seater_nmpc.plausibility.installation.knowledge import Knowledge

Array = NDArray[np.float64]

DRIVERS = ("sequence", "class")
_BEGIN = 10.0  # [s] clock at the start
_LONGEST = {"sequence": 170.0, "class": 60.0}  # [s]
_AFTER = 1.5  # [s] that a run goes on after its result: whatever moves then counts
_IDLE = 5.0  # [s] without motion after which a run of the class is over
_STANDING = 1e-4  # [m/s, rad/s] up to here: slower than the verdict's own bound for standing
_CRASHED = -0.05  # [m] so deep in a wall, a run is over
_PRIOR = (0.3, math.radians(10.0))  # [m, rad] the rough pose is off by up to this
_NEES_95 = 7.81  # 95 % of chi-square with 3 degrees of freedom
_ORIGIN = (3.0, -1.5, 0.6)  # base_link in odom at the start


@dataclass(frozen=True)
class Job:
    """All that a run depends on."""

    config: str
    row: Row
    seed: int
    driver: str = "sequence"  # of DRIVERS
    told: str = "nothing"
    series: int = 1  # dockings of the same chair, from other starts; the last one is judged
    check: str = ""  # sequence/installation_check; empty: as the configuration has it


@dataclass(frozen=True)
class Log:
    """What happened in a run: the motion, commands (time, v, omega), estimates (see Driver), and the odometry as it
    arrived (time of arrival, v, omega)."""

    motion: Motion
    commands: Array
    estimates: Array
    odometry: Array


def run_job(job: Job) -> dict[str, Any]:
    """The verdict on one run."""
    return run(job)[0]


def run(job: Job) -> tuple[dict[str, Any], Log]:
    """The verdict, and what happened. The same job gives the same bits."""
    begun = time.perf_counter()
    knowledge, codes, far = None, [], 0
    for number in range(job.series):
        loop = _Loop(job, number, knowledge)
        loop.drive()
        knowledge = loop.driver.knowledge
        codes.append("TIMEOUT" if loop.driver.result is None else loop.driver.result.code.name)
        far += loop.driver.result is not None and loop.driver.result.success and loop.far
    log, driver = loop.log(), loop.driver
    result = driver.result
    succeeded = None if job.driver == "class" else result is not None and result.success
    files = load_files(job.config, job.row.markers)
    code = "TIMEOUT" if result is None else result.code.name
    values = {
        "row": job.row.name,
        "seed": job.seed,
        "start": [round(value, 4) for value in loop.start],
        **judge(log.motion, files.chair, files.dock, succeeded),
        "code": "" if job.driver == "class" else code,
        "text": "" if result is None else result.text,
        "retries": 0 if result is None else result.retries,
        "built": dataclasses.asdict(loop.built) | {"patches": len(loop.built.patches)},
        **_estimate_values(log.estimates),
        "outcomes": loop.outcomes(),
        **loop.after_fault(),
        "position_sd_m": 0.0 if result is None else result.position_sd,
        "heading_sd_deg": 0.0 if result is None else math.degrees(result.heading_sd),
        "series_codes": codes,
        "series_far": far,  # successes beyond 20 mm or 2 deg
        "installation": None if loop.installation is None else dataclasses.asdict(loop.installation),
        "wall_s": round(time.perf_counter() - begun, 2),
    }
    return values, log


class _Loop:
    """Chair, odometry, camera and driver, step by step."""

    def __init__(self, job: Job, number: int = 0, knowledge: Knowledge | None = None) -> None:
        """`number` of the series; `knowledge` of the installation by the dockings before."""
        self._job, effects = job, job.row.effects
        later = [number] if number else []  # chair and installation stay, all else is drawn anew
        files = load_files(job.config, job.row.markers)
        self._files = files
        streams = [np.random.default_rng([job.seed, stream, *(later if stream != 2 else [])]) for stream in range(6)]
        wrong = job.row.installation
        self.installation = None if wrong is None else wrong.drawn(np.random.default_rng([job.seed, 6]))
        camera = DockCamera(files.chair, files.dock, effects.pictures, streams[0], self.installation)
        self._camera, self._marker_noise = camera, np.random.default_rng([job.seed, 7, *later])
        self.start = draw_start(job.row.starts, files.chair, files.dock, camera, streams[1])
        self.built = draw_built(effects, streams[2])
        self._chair = IndependentChair(effects, self.built, self.start, streams[3])
        self._injector = Injector(job.row.fault, files.dock.markers)
        self._odometry = WheelOdometry(effects.encoders, _BEGIN, _ORIGIN, streams[4])
        self.driver = self._make_driver(streams[5])
        if knowledge is not None:
            self.driver.knowledge = knowledge
        self._image = _BEGIN + streams[5].uniform(0.0, 1.0 / effects.pictures.rate)
        self._images: list[tuple[float, Any, Any]] = []
        self._rows: list[list[float]] = []
        self._commands: list[list[float]] = []
        self._heard: list[list[float]] = []
        self._ended = math.inf

    def _make_driver(self, rng: np.random.Generator) -> Driver:
        job, base = self._job, self._files.parameters
        view = 0.0 if job.driver == "class" else job.row.effects.pictures.view  # camera_info comes with each image
        tools = kept(job.config, job.row.markers, view)
        if job.driver == "class":  # its defaults, not those of the files
            base = NmpcParameters(control=ControlParameters())
        parameters = told_parameters(base, job.told, job.row.effects, self.built)
        if job.driver == "class":
            return ClassDriver(self._files, tools, parameters)
        if job.check:
            sequence = dataclasses.replace(parameters.sequence, installation_check=job.check)
            parameters = dataclasses.replace(parameters, sequence=sequence)
        prior = None
        way, direction, turn = rng.uniform(0.0, _PRIOR[0]), rng.uniform(-math.pi, math.pi), rng.uniform(-1.0, 1.0)
        if job.row.starts != "front":
            prior = compose(_ORIGIN, inverse(self.start))
            prior = prior + [way * math.cos(direction), way * math.sin(direction), turn * _PRIOR[1]]
        return SequenceDriver(self._files, tools, parameters, prior)

    def drive(self) -> None:
        """Until the driver has ended, the chair has crashed, or time is over."""
        steps, ended, moved = 0, math.inf, _BEGIN
        while True:
            now = _BEGIN + steps * STEP
            chair = self._chair
            self._injector.time(now, chair, self.driver.result is not None)
            self._exchange(now)
            self._rows.append([now, chair.x, chair.y, chair.heading, chair.v, chair.omega])
            if self.driver.result is not None and ended == math.inf:
                ended = self._ended = now
            if max(abs(chair.v), abs(chair.omega)) > _STANDING:
                moved = now
            idle = self._job.driver == "class" and now - moved > _IDLE
            if now - _BEGIN >= _LONGEST[self._job.driver] or now - ended >= _AFTER or idle:
                return
            if steps % 20 == 0 and self._gap() < _CRASHED:
                return
            self._injector.step(now, chair)
            steps += 1

    @property
    def far(self) -> bool:
        """Whether the chair is too far off for a success."""
        return is_far(math.hypot(self._chair.x, self._chair.y), math.degrees(self._chair.heading))

    def _gap(self) -> float:
        pose = np.array([[self._chair.x, self._chair.y, self._chair.heading]])
        return smallest_gap(pose, self._files.chair, self._files.dock)

    def _exchange(self, now: float) -> None:
        """Images, odometry and commands of this instant."""
        chair, pictures = self._chair, self._job.row.effects.pictures
        if self._job.driver == "sequence" and now >= self._image:
            self._image += 1.0 / pictures.rate
            pose = (chair.x, chair.y, chair.heading)
            self._images.append(
                (now, self._injector.image(self._camera.look(pose)), self._camera.sights(pose, self._marker_noise))
            )
        while self._images and self._images[0][0] + pictures.latency <= now + 1e-9:
            self.driver.image(*self._images.pop(0))
        self._odometry.look(now, chair.rolled)
        messages = [self._injector.odometry(message) for message in self._odometry.messages(now)]
        self._heard += [[now, message.v, message.omega] for message in messages]
        asked = [self.driver.odometry(message, chair) for message in messages]
        for command in [*asked, self.driver.time(now, chair)]:
            if command is not None:
                self._commands.append([now, *command])
                chair.command(now, *self._injector.command(*command))

    def log(self) -> Log:
        """Of what was driven."""
        rows = np.array(self._rows)
        rows[:, 0] -= _BEGIN
        commands = np.array(self._commands).reshape(-1, 3) - [_BEGIN, 0.0, 0.0]
        estimates = np.array(self.driver.estimates).reshape(-1, 6) - [_BEGIN, 0.0, 0.0, 0.0, 0.0, 0.0]
        heard = np.array(self._heard).reshape(-1, 3) - [_BEGIN, 0.0, 0.0]
        return Log(Motion(rows[:, 0], rows[:, 1:4], rows[:, 4:6]), commands, estimates, heard)

    def after_fault(self) -> dict[str, float | None]:
        """Time from the fault's beginning to the result [s], and the true way driven from then on [m]."""
        began = self._injector.began
        if began is None:
            return {"noticed_s": None, "moved_after_fault_m": None}
        rows = np.array(self._rows)
        after = rows[rows[:, 0] >= began - 1e-9]
        way = float(np.hypot(*np.diff(after[:, 1:3], axis=0).T).sum())
        return {
            "noticed_s": self._ended - began if math.isfinite(self._ended) else None,
            "moved_after_fault_m": way,
        }

    def outcomes(self) -> dict[str, int]:
        """What became of the images, by the observer's words."""
        if not isinstance(self.driver, SequenceDriver):
            return {}
        return {outcome.name: count for outcome, count in sorted(self.driver.observer.images.counts.items())}


def _estimate_values(estimates: Array) -> dict[str, float | None]:
    if not len(estimates):
        return dict.fromkeys(("estimate_error_m", "estimate_error_deg", "nees_mean", "nees_above_95"))
    return {
        "estimate_error_m": float(np.hypot(estimates[:, 1], estimates[:, 2]).max()),
        "estimate_error_deg": math.degrees(float(np.abs(estimates[:, 3]).max())),
        "nees_mean": float(estimates[:, 4].mean()),
        "nees_above_95": float((estimates[:, 4] > _NEES_95).mean()),
    }
