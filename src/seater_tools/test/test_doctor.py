"""The doctor names the faults of an installation, and is silent about good ones."""

from __future__ import annotations

import copy
import dataclasses
import io
import json
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest
from as_typed import run

from seater_common.params import read_yaml
from seater_tools.doctor import checks, files, inputs, obstacles, traffic
from seater_tools.doctor.gather.drive import SLOWEST, SPEED, Stepper, pieces
from seater_tools.doctor.gather.image import white_of
from seater_tools.doctor.observations import Live, Observations, ObstaclesSeen, Traffic
from seater_tools.doctor.report import as_json, describe, support_zip
from seater_tools.doctor.setup import FileSeen
from seater_tools.doctor.trial.accuracy import fault_outcomes
from seater_tools.doctor.trial.faults import FAULTS
from seater_tools.doctor.trial.scene import draw_scene
from seater_tools.doctor.trial.watch import Watch
from seater_tools.doctor.verdict import Verdict

CONFIG = Path(__file__).resolve().parents[3] / "config"
STATIC = [
    f for f in FAULTS if f.family in ("files", "computer") and f.check not in ("files in use", "clock", "processor")
]
# Some of those that need rendered images; all of them: rosrun seater_tools doctor_accuracy. The mount: doctor_move.test
LIVE = ("marker 1 10 % too small", "over-exposed", "camera's clock 2 s behind", "odometry frozen")
SELDOM = ("over-exposed", "camera's clock 2 s behind")  # of them with `./seater test --all` only


@pytest.mark.parametrize("fault", STATIC, ids=lambda f: f.name)
def test_faults_of_files_are_named_before_anything_runs(fault) -> None:
    scene = draw_scene(CONFIG, 3)
    assert not crosses(Observations(scene.files, scene.machine))
    fault.edit(scene)
    first = crosses(Observations(scene.files, scene.machine))[0]
    assert first.name == fault.check and fault.word in first.what and first.remedy


@pytest.mark.parametrize(
    "fault",
    [pytest.param(f, marks=pytest.mark.extensive) if f.name in SELDOM else f for f in FAULTS if f.name in LIVE],
    ids=lambda f: f.name,
)
def test_faults_of_a_simulated_system_are_named(fault) -> None:
    (outcome,) = fault_outcomes(CONFIG, [fault], 1000)
    assert outcome.named, outcome.crosses


@pytest.fixture(scope="module")
def good() -> Observations:
    return Watch(draw_scene(CONFIG, 4)).observe()


def test_a_good_installation_has_no_cross_and_its_reports_say_the_same(good: Observations) -> None:
    verdicts = checks.run(good)
    assert not [verdict for verdict in verdicts if verdict.ok is False]
    content = json.loads(as_json(verdicts, good))
    assert content["ok"] and content["running"] and len(content["checks"]) == len(verdicts)
    assert {entry["result"] for entry in content["checks"]} == {"ok", "not judged"}
    text = describe(verdicts)
    assert text.count("\u2714") == sum(verdict.ok is True for verdict in verdicts)
    archive = zipfile.ZipFile(io.BytesIO(support_zip(verdicts, good)))
    assert archive.read("config/dock.yaml").decode().endswith(good.files["dock"].text)
    assert len(archive.read("record/odometry.csv").splitlines()) == len(good.live.odometry)


def test_what_launch_arguments_say_is_no_contradiction_to_the_files(good: Observations) -> None:
    given = {}
    for launch in ("wheelchair.launch", "docking.launch"):
        text = (CONFIG.parent / "src" / "seater_bringup" / "launch" / launch).read_text()
        given |= dict(re.findall(r'<param name="\w+/((?:controller|safety)/[\w/]+)"\s+value="([^"]*)"', text))
    assert len(given) > 2
    assert good.live is not None
    told = copy.deepcopy(dict(good.live.told))
    for path, value in given.items():
        *folders, key = path.split("/")
        inner = told
        for folder in folders:
            inner = inner[folder]
        inner[key] = "on_the_way" if value.startswith("$(arg") else float(value)
    changed = dataclasses.replace(good, live=dataclasses.replace(good.live, told=told))
    assert traffic.told(changed).ok is True, traffic.told(changed).what


def test_marks_and_remedies_of_a_fault_are_printed() -> None:
    line = describe([Verdict("gate", False, "is silent", "start it")]).splitlines()[0]
    assert line.startswith("\u2718 gate") and line.endswith("is silent  -> start it")


@pytest.mark.parametrize(
    ("check", "changes"),
    [
        (
            inputs.gate,
            {"gate": dataclasses.make_dataclass("G", ["state", "reason", "emergency_stop"])("FAULT", "x", False)},
        ),
        (inputs.complaints, {"complaints": (("camera", "no frames"),)}),
        (inputs.base_frames, {"frames": ("odom", "odom")}),
        (traffic.single_senders, {"topics": {"odom": Traffic("odom", ("/a", "/b"))}}),
        (inputs.at_rest, {"odometry": np.array([[1.0, 0, 0, 0, 0, 0], [2.0, np.nan, 0, 0, 0, 0]])}),
    ],
)
def test_what_the_simulator_cannot_make(good: Observations, check, changes) -> None:
    assert good.live is not None and check(good).ok
    assert check(dataclasses.replace(good, live=dataclasses.replace(good.live, **changes))).ok is False


@pytest.mark.parametrize(("hertz", "ok"), [(9.8, True), (9.5, False)])
def test_a_rate_is_counted_with_its_error(good: Observations, hertz: float, ok: bool) -> None:
    """A commissioned chair with an odometry of 10 Hz was told "10 Hz, 10 are needed"."""
    assert good.live is not None
    arrivals = np.arange(0.0, 4.0, 1.0 / hertz)
    topics = {**good.live.topics, "odom": Traffic("/odom", ("/base",), (), arrivals, arrivals)}
    said = traffic.rate_of("odom")(dataclasses.replace(good, live=dataclasses.replace(good.live, topics=topics)))
    assert said.ok is ok, said


SCAN = Traffic("/scan", ("/lidar",))
TEN_HZ = np.arange(0.0, 4.0, 0.1)


@pytest.mark.parametrize(
    ("seen", "ok", "words"),
    [
        (None, None, "nothing looks for people"),
        (ObstaclesSeen("scan", (SCAN,), TEN_HZ), True, "scan, 10 Hz of /scan"),
        (ObstaclesSeen("scan", (Traffic("/scan"),), TEN_HZ), False, "nobody sends /scan"),
        (ObstaclesSeen("scan", (SCAN,)), False, "obstacle_finder hears nothing of /scan"),
        (ObstaclesSeen("scan"), False, "obstacle_finder hears nothing of any sensor"),
        (ObstaclesSeen("scan", (SCAN,), TEN_HZ, "frame laser does not exist"), False, "frame laser does not exist"),
        (ObstaclesSeen("depth", (SCAN,), TEN_HZ[::5]), False, "depth, 2 Hz of /scan, 4 are needed"),
    ],
)
def test_the_sensor_of_obstacles(good: Observations, seen: ObstaclesSeen | None, ok: bool | None, words: str) -> None:
    assert good.live is not None
    said = obstacles.sensor(dataclasses.replace(good, live=dataclasses.replace(good.live, obstacles=seen)))
    assert (said.ok, words in said.what) == (ok, True), said
    assert (ok is False) == bool(said.remedy)


def test_the_file_of_obstacles_is_checked(good: Observations) -> None:
    values = read_yaml(CONFIG / "obstacles.yaml")
    values["track"]["memory"] = -1.0
    file = FileSeen("obstacles.yaml", values=values)
    verdict = files.file_of("obstacles")(dataclasses.replace(good, files={**good.files, "obstacles": file}))
    assert verdict.ok is False and "track/memory" in verdict.what


def test_without_messages_nothing_is_judged_that_needs_them(good: Observations) -> None:
    silent = checks.run(dataclasses.replace(good, live=Live(duration=3.0)))
    assert {v.name for v in silent if v.ok is False} == {"nodes"}


def test_white_at_the_sensors_limit() -> None:
    image = np.full((100, 100), 40, dtype=np.uint8)
    image[30:70, 30:50], image[30:70, 50:70] = 255, 200
    square = np.array([[30.0, 30.0], [69.0, 30.0], [69.0, 69.0], [30.0, 69.0]])
    cut_off, contrast = white_of(image, [square])
    assert cut_off == pytest.approx(0.5, abs=0.05) and contrast == pytest.approx(215.0)
    assert white_of(image, []) is None


class Chair:
    """Obeys by `gain`, and its odometry says `scale` of it; at 20 Hz."""

    def __init__(self, gain: float = 1.0, scale: float = 1.0, silent_from: float = 1e9) -> None:
        self.pose, self.way, self.time = np.zeros(3), 0.0, 0.0
        self.gain, self.scale, self.silent_from = gain, scale, silent_from

    def drive(self, stepper: Stepper) -> list[tuple[float, float]]:
        sent = []
        while not stepper.over and self.time < 60.0:
            if self.time < self.silent_from:
                stepper.odometry(self.time, self.pose, self.time)
            v, omega = stepper.command(self.time)
            sent.append((v, omega))
            self.way += self.gain * v * 0.05
            c, s = np.cos(self.pose[2]), np.sin(self.pose[2])
            self.pose = self.pose + self.gain * self.scale * 0.05 * np.array([v * c, v * s, omega])
            self.time += 0.05
        return [*sent, stepper.command(self.time)]


def stepper(way: float = 0.3) -> Stepper:
    return Stepper(pieces(way, 0.35), draw_limits(), 0.05)


def draw_limits():
    from seater_common.geometry import Limits

    return Limits()


def test_the_drive_comes_back_to_where_it_began_within_its_limits() -> None:
    chair, driver = Chair(), stepper()
    sent = np.array(chair.drive(driver))
    assert driver.over and not driver.stopped and sent[-1].tolist() == [0.0, 0.0]
    assert np.linalg.norm(chair.pose[:2]) < 0.04 and len(driver.stands) == 7
    assert np.abs(np.diff(sent, axis=0)).max(axis=0)[0] <= 0.5 * 0.05 + 1e-9
    assert np.abs(sent).max(axis=0)[0] <= SPEED


@pytest.mark.parametrize(
    ("chair", "word", "farthest"),
    [
        (Chair(gain=0.0), "does not move", 0.0),
        (Chair(gain=-1.0), "other way", 0.06),
        (Chair(scale=0.3), "in time", SLOWEST * 0.05 + 1.5 * SPEED + 0.01),
        (Chair(silent_from=1.8), "no odometry", 0.05),
    ],
)
def test_what_goes_wrong_ends_the_drive_at_zero(chair: Chair, word: str, farthest: float) -> None:
    driver = stepper()
    sent = chair.drive(driver)
    assert word in driver.stopped and sent[-1] == (0.0, 0.0) and abs(chair.way) <= farthest


def test_as_typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    done = run("doctor", "--json", "--zip", tmp_path / "a.zip")
    assert done.returncode == 0 and not json.loads(done.stdout)["running"] and (tmp_path / "a.zip").exists()
    broken = tmp_path / "chair.yaml"
    broken.write_text("width: wide\n")
    done = run("doctor", "--chair", broken)
    assert done.returncode == 1 and "\u2718 chair file" in done.stdout
    assert run("doctor", "--move").returncode == 2 and run("doctor", "--way", "3").returncode == 2


def crosses(observations: Observations) -> list[Verdict]:
    return [verdict for verdict in checks.run(observations) if verdict.ok is False]


@pytest.mark.parametrize(("told", "ok"), [(1.0, True), (0.0, None)])
def test_what_a_launch_argument_switches_on_is_no_difference(good: Observations, told: float, ok: bool | None) -> None:
    """panel:=true switches hold_to_run on; that it is off though the file has it on, is one."""
    assert good.live is not None
    file = {"hold_to_run": 0 if ok else 1}
    safety = FileSeen("safety.yaml", values=file)
    live = dataclasses.replace(good.live, told={"safety": {"hold_to_run": told}})
    said = traffic.told(dataclasses.replace(good, files={**good.files, "safety": safety}, live=live))
    assert said.ok is (ok or False), said
