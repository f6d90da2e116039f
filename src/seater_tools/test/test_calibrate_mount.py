"""`./seater calibrate mount` as a person types it, and against rendered images."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from as_typed import run
from drive_by_hand import CAMERA, Truth, make_drive
from printed import CONFIG, DEFAULT_DOCK
from test_drive import write_bag

from seater_common.camera_model import COVARIANCE, CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.params import load, read_yaml
from seater_sim.camera.camera import Camera
from seater_sim.settings import KINEMATIC, PlantSettings, SimulatorSettings
from seater_tools.correct.known import bar_sd
from seater_tools.correct.sizes import CORRECTED, refuse_corrected
from seater_tools.drive.gather import Gatherer
from seater_tools.mount.copies import dock_text
from seater_tools.mount.prior import Lengths
from seater_tools.mount.result import judge
from seater_tools.mount.solve import solve
from seater_tools.trial.drive import Face, To, drive_chair
from seater_tools.trial.truth import Errors, draw_installation

NODE = "calibrate"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a drive of 36 images and its camera."""
    folder = tmp_path_factory.mktemp("drive")
    drive = make_drive(Truth())
    drive.chosen(np.arange(0, len(drive.stamps), 5)).save(folder / "drive.npz")
    camera = {
        "image_width": 1280,
        "image_height": 720,
        "camera_matrix": {"data": CAMERA.K.ravel().tolist()},
        "distortion_model": "plumb_bob",
        "distortion_coefficients": {"data": CAMERA.D.tolist()},
    }
    (folder / "camera.yaml").write_text(yaml.safe_dump(camera))
    return folder


def test_copies_picture_and_values_are_written_once(files: Path, tmp_path: Path) -> None:
    words = ("mount", "--drive", files / "drive.npz", "--camera", files / "camera.yaml", "--results", tmp_path)
    tape = ("--measured-distance", "1", "2", f"{1000 * np.hypot(0.699, 0.022):.1f}")
    done = run(NODE, *words, *tape)
    assert done.returncode == 0, done.stderr
    assert "All lengths follow from what was measured by hand" in done.stdout
    assert sorted(p.name for p in tmp_path.iterdir()) == ["chair.yaml", "default.yaml", "mount.json", "mount.png"]
    chair = load(Chair, read_yaml(tmp_path / "chair.yaml"), "chair")
    assert (chair.camera.x, chair.camera.y) == pytest.approx(Truth().mount[:2], abs=0.003)
    assert (tmp_path / "chair.yaml").read_text().startswith("# Camera calibrated: 20")
    kept = [line for line in (CONFIG / "chair.yaml").read_text().split("\n") if "#" in line and "camera" not in line]
    assert {line.split("#")[1] for line in kept} <= {
        line.split("#")[1] for line in (tmp_path / "chair.yaml").read_text().split("\n") if "#" in line
    }
    assert json.loads((tmp_path / "mount.json").read_text())["missing"] == []
    before = (tmp_path / "default.yaml").read_bytes()
    again = run(NODE, *words)
    assert again.returncode == 1 and "exists already; --force overwrites it" in again.stderr
    assert (tmp_path / "default.yaml").read_bytes() == before
    assert run(NODE, *words, "--force").returncode == 0
    assert (tmp_path / "default.yaml").read_bytes() != before  # now without the tape


def test_the_new_dock_file_is_not_printed_from(files: Path) -> None:
    dock = load(Dock, read_yaml(DEFAULT_DOCK), "dock")
    solution = solve(make_drive(Truth()), CAMERA, Chair().camera, dock, Lengths(), 50)
    calibration = judge(solution, dock, Lengths())
    text = dock_text(DEFAULT_DOCK.read_text(), "dock", dock, calibration, "today")
    with pytest.raises(ValueError, match="corrected for a print"):
        refuse_corrected(text, "dock")
    assert bar_sd(text) is None  # no bar was measured
    by_bar = f"{CORRECTED}99.00 % of default.yaml (bar of 190 mm on a4: 188.1 mm)\n{DEFAULT_DOCK.read_text()}"
    assert bar_sd(by_bar) == pytest.approx(0.25 / 190.0)
    assert bar_sd(dock_text(by_bar, "dock", dock, calibration, "today")) == pytest.approx(0.25 / 190.0)
    # Once more, after it was taught: the docked pose was measured with another camera mount and other markers.
    taught = text.replace("\n", "\n# Taught: 2026-11-27T16:05:09Z, 60 measurements\n", 1)
    again = dock_text(taught, "dock", dock, calibration, "tomorrow")
    assert "# Taught: " not in again and again.startswith(CORRECTED)
    assert again.count("# Markers calibrated: ") == 1 and "# Markers calibrated: tomorrow\n" in again


def test_the_files_of_an_installation_are_replaced(files: Path, tmp_path: Path) -> None:
    here = ("--installation", tmp_path)
    assert run("installation", tmp_path).returncode == 0
    (tmp_path / "camera.yaml").write_text((files / "camera.yaml").read_text())
    for _ in range(2):  # the second time over the results of the first
        done = run(NODE, "mount", *here, "--drive", files / "drive.npz")
        assert done.returncode == 0, done.stderr
        for old in tmp_path.glob("*.yaml.2*"):  # twice within a second, the second would be refused
            old.unlink()
    assert "Next: ./seater sheets" in done.stdout
    for name in ("chair.yaml", "dock.yaml"):
        assert (tmp_path / name).read_text() == (tmp_path / "calibrate_mount" / name).read_text()
    text = (tmp_path / "chair.yaml").read_text()
    assert text.count("# Camera calibrated: ") == 1
    assert load(Chair, read_yaml(tmp_path / "chair.yaml"), "c").camera.x == pytest.approx(Truth().mount[0], abs=0.01)


def test_a_camera_that_says_how_certain_it_is_is_found_too(files: Path, tmp_path: Path) -> None:
    values = read_yaml(files / "camera.yaml")
    values["camera_matrix"]["data"][0] += 0.2
    values["camera_name"] = "front"
    values[COVARIANCE] = {"data": np.diag([0.06, 0.06, 0.2, 0.2, *[1e-7] * 5]).ravel().tolist()}
    assert run("installation", tmp_path).returncode == 0
    camera = tmp_path / "camera.yaml"
    for _ in range(2):
        camera.write_text("# Lens calibrated: today\n# 20 views\n" + yaml.safe_dump(values))
        done = run(NODE, "mount", "--installation", tmp_path, "--drive", files / "drive.npz")
        assert done.returncode == 0 and "Give camera.yaml to the camera's driver" in done.stdout, done.stderr
        for old in tmp_path.glob("*.yaml.2*"):
            old.unlink()
    lines = camera.read_text().splitlines()
    assert lines[:2] == ["# Lens calibrated: today", "# 20 views"] and lines[2].startswith("# With the mount: 20")
    assert "camera_name: front" in lines and not lines[3].startswith("#")
    found = CameraModel.load(camera)
    assert found.covariance is not None and 0.0 < found.covariance[0, 0] < 0.06
    assert abs(found.K[0, 0] - CAMERA.K[0, 0]) < 4.0 * np.sqrt(found.covariance[0, 0])
    assert found.P[0, 0] > 0.0
    assert "Camera calibrated: " in (tmp_path / "chair.yaml").read_text()


def test_files_that_were_given_are_never_overwritten(files: Path, tmp_path: Path) -> None:
    dock = tmp_path / "dock.yaml"
    dock.write_text(DEFAULT_DOCK.read_text())
    words = ("--drive", files / "drive.npz", "--camera", files / "camera.yaml", "--results", tmp_path, "--force")
    done = run(NODE, "mount", *words, "--dock", dock)
    assert done.returncode == 2 and "holds dock.yaml itself; choose another folder" in done.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["dock.yaml"] and dock.read_text() == DEFAULT_DOCK.read_text()


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ((), "one of the arguments --bag --drive --simulate is required"),
        (("--drive", "nowhere.npz"), "cannot read nowhere.npz"),
        (("--simulate", "-1"), "--simulate: is -1, must be >= 0"),
        (("--drive", "x", "--measured-side", "7", "100"), "--measured-side: marker is '7', must be one of 0, 1, 2"),
        (("--drive", "x", "--measured-side", "1", "0.15"), "--measured-side: is '0.15' mm, must be 5 to 2000 mm"),
        (("--drive", "x", "--measured-distance", "1", "1", "700"), "marker 1 is named twice"),
        (("--drive", "x", "--measured-distance", "1", "2", "wide"), "is 'wide' mm, must be 50 to 20000 mm"),
        (("--drive", "x", "--dock", "nowhere.yaml"), "cannot read nowhere.yaml"),
    ],
)
def test_wrong_input_is_named(tmp_path: Path, words: tuple[str, ...], problem: str) -> None:
    done = run(NODE, "mount", *words, "--results", tmp_path / "out")
    assert done.returncode == 2
    assert problem in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_drive_that_does_not_constrain_writes_nothing(files: Path, tmp_path: Path) -> None:
    drive = make_drive(Truth(moves=[(0.25, 0.0, 7.0), (-0.25, 0.0, 6.0)]))
    drive.save(tmp_path / "straight.npz")
    words = ("--drive", tmp_path / "straight.npz", "--camera", files / "camera.yaml", "--results", tmp_path / "out")
    done = run(NODE, "mount", *words)
    assert done.returncode == 3
    assert "turn on the spot, 25 deg to the left and to the right" in done.stdout
    assert not (tmp_path / "out").exists()


def test_a_bag_is_read_by_its_topics(tmp_path: Path) -> None:
    pytest.importorskip("rosbag")
    write_bag(tmp_path / "drive.bag")  # of a marker 3
    words = ("mount", "--bag", tmp_path / "drive.bag", "--results", tmp_path / "out")
    done = run(NODE, *words)
    assert done.returncode == 2 and "the drive shows markers 3, the dock file has none of them" in done.stderr
    done = run(NODE, *words, "--odometry-topic", "/wheel_odom")
    assert done.returncode == 2 and "has no messages on wheel_odom" in done.stderr
    dock = tmp_path / "dock.yaml"
    dock.write_text(DEFAULT_DOCK.read_text().replace("id: 0", "id: 3"))
    done = run(NODE, *words, "--dock", dock)
    assert done.returncode == 2 and "nothing like the two files explains this drive" in done.stderr


@pytest.mark.extensive  # test_commissioning.py calibrates out of images always
def test_from_rendered_images() -> None:
    """Images of seater_sim, read by seater_perception, which believes the files."""
    sp = pytest.importorskip("seater_perception")
    dock, camera_file = Dock(), CONFIG / "cameras" / "d455.yaml"
    truth = draw_installation(Chair().camera, dock, Errors(), np.random.default_rng(8))
    settings = SimulatorSettings(plant=PlantSettings(kind=KINEMATIC))
    model = CameraModel.load(camera_file)
    camera = Camera(model, truth.mount, truth.dock, settings.camera)
    layout = sp.load_dock_layout(yaml.safe_load(DEFAULT_DOCK.read_text()))
    detector = sp.DockTracker(
        sp.CameraModel.raw(sp.load_calibration(str(camera_file))), layout, sp.default_parameters()
    )
    gatherer = Gatherer(model)
    sizes = {marker.id: marker.size for marker in dock.markers}

    def look(frame) -> None:  # type: ignore[no-untyped-def]
        for seen in detector.detect(camera.render(frame.pose, frame.v, frame.omega, seed=1, index=1)).markers:
            gatherer.pose(frame.stamp, seen.id, sizes[seen.id], seen.corners, seen.hypotheses[0].pose, seen.covariance)

    script = (To(-0.6), To(-1.6), Face(0.45), Face(-0.45), Face(0.0), To(-0.6), To(-1.6))
    drive_chair(settings, Chair().limits, 8, look, gatherer.odometry, script, image_period=0.4)
    true = {marker.id: np.array(marker.position) for marker in truth.dock.markers}
    tape = Lengths(distances=((1, 2, float(np.linalg.norm(true[1] - true[2]))),))
    found = judge(solve(gatherer.drive(), model, Chair().camera, dock, tape, 80), dock, tape)
    assert found.missing == []
    mount = {value.name: value for value in found.mount}
    # So short a drive, with an image in 0.4 s, leaves x and yaw uncertain, and says so.
    for name in ("x", "y", "roll", "pitch", "yaw"):
        assert abs(mount[name].value - getattr(truth.mount, name)) < 3.0 * max(mount[name].sd, 1e-4)
    assert mount["x"].sd < 0.008 and mount["y"].sd < 0.003 and mount["yaw"].sd < 0.004
    assert mount["roll"].sd < 0.0005 and mount["pitch"].sd < 0.0005
    for marker in truth.dock.markers:
        assert found.markers[marker.id][-1].value == pytest.approx(marker.size, rel=0.002)
