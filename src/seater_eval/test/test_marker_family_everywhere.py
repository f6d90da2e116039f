"""One file makes a marker family: perception detects it, the simulator and the evaluation render it."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_common.marker_family import marker_family, predefined_names
from seater_eval.perception.images.degraded_camera import load_degraded_camera
from seater_eval.perception.images.render import Print, clean_image, corners_of, exposed
from seater_eval.perception.peers import make_peer
from seater_eval.perception.subject import camera_model
from seater_sim.camera.camera import Camera
from seater_sim.settings import CameraSettings

CONFIG = Path(__file__).resolve().parents[3] / "config"
FAMILY = {"bits": 3, "border": 1, "correctable_bits": 0, "codes": ["110 010 001", "101 100 110", "111 010 000"]}


@pytest.fixture
def family(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a family that only this file knows."""
    (tmp_path / "three_by_three.yaml").write_text(yaml.safe_dump(FAMILY))
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(tmp_path))
    return "three_by_three"


@pytest.mark.parametrize("name", [*predefined_names(), "three_by_three"])
def test_both_languages_read_the_same_codes(name: str, family: str) -> None:
    ours, theirs = marker_family(name), sp.MarkerFamily.named(name)
    assert (theirs.name, theirs.bits, theirs.border) == (ours.name, ours.bits, ours.border)
    assert (theirs.cells, theirs.correctable_bits, len(theirs)) == (ours.cells, ours.correctable_bits, len(ours))
    assert all(np.array_equal(theirs.code(i), ours.codes[i]) for i in range(len(ours)))


def test_the_evaluation_draws_what_perception_detects(family: str) -> None:
    camera = load_degraded_camera(CONFIG / "cameras" / "degraded.yaml")
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [0.05, 0.02, 0.8]
    print_ = Print(family, 2, 0.1, pose)
    image = exposed(clean_image([print_], camera), camera.noise_sd, np.random.default_rng(1))
    detector = sp.DockDetector(camera_model(camera), sp.layout_of_equal_markers(family, 0.1), sp.default_parameters())
    truth = corners_of(print_, camera.K)
    ours, theirs = detector.detect(image).markers, make_peer("opencv_none", camera.K, 0.1, family)(image)
    assert [marker.id for marker in ours] == [marker.id for marker in theirs] == [2]
    assert np.abs(ours[0].corners - truth).max() < 0.05  # measured 0.01
    assert np.abs(theirs[0].corners - truth).max() < 2.0  # as found: on whole pixels


def test_the_simulator_draws_what_perception_detects(family: str) -> None:
    calibration = CONFIG / "cameras" / "d455.yaml"
    model = CameraModel.from_mapping(yaml.safe_load(calibration.read_text()))
    camera = Camera(model, Chair().camera, dataclasses.replace(Dock(), dictionary=family), CameraSettings())
    image: NDArray[np.uint8] = camera.render((-1.0, 0.0, 0.0))
    seen_by = sp.CameraModel.raw(sp.load_calibration(str(calibration)))
    detector = sp.DockDetector(seen_by, sp.layout_of_equal_markers(family, 0.1), sp.default_parameters())
    assert [marker.id for marker in detector.detect(image).markers] == [0, 1, 2]
