"""The Python binding: what goes in comes out, wrong input is refused, other threads run meanwhile."""

import pickle
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

import seater_perception as sp

CONFIG = Path(__file__).resolve().parents[3] / "config"
F, CX, CY = 640.0, 639.5, 359.5


def camera() -> sp.CameraModel:
    return sp.CameraModel.raw(sp.load_calibration(str(CONFIG / "cameras" / "d455.yaml")))


def marker_image(size: int = 126, at: tuple[int, int] = (500, 300)) -> np.ndarray:
    """Marker 3 of DICT_4X4_50, frontal, `size` pixels wide, its first pixel at `at`."""
    image = np.full((720, 1280), 215, np.uint8)
    print_ = cv2.aruco.drawMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 3, size)
    image[at[1] : at[1] + size, at[0] : at[0] + size] = np.where(print_ > 127, 215, 40)
    return cv2.GaussianBlur(image, (0, 0), 0.8)


def test_detects_a_marker_where_it_is() -> None:
    detector = sp.DockDetector(camera(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1), sp.default_parameters())
    (marker,) = detector.detect(marker_image()).markers
    assert marker.id == 3
    # The first pixel's outer edge is half a pixel before its centre.
    expected = np.array([[499.5, 299.5], [625.5, 299.5], [625.5, 425.5], [499.5, 425.5]])
    assert np.abs(marker.corners - expected).max() < 0.1
    pose = marker.hypotheses[0].pose
    z = F * 0.1 / 126
    assert pose.shape == (4, 4)
    assert pose[:3, 3] == pytest.approx([(562.5 - CX) * z / F, (362.5 - CY) * z / F, z], abs=1e-3)
    assert marker.hypotheses[0].covariance.shape == (6, 6)
    assert np.all(np.linalg.eigvalsh(marker.covariance) > 0.0)
    assert sum(h.weight for h in marker.hypotheses) == pytest.approx(1.0)


def test_the_mount_of_the_camera_is_used_and_checked() -> None:
    """Markers are known to stand upright: a camera that looks 0.3 rad down makes the other solution less unlikely."""
    marker = {"id": 3, "size": 0.1, "position": [1.0, 0.0, 0.0], "normal_yaw": 3.1}
    layout = sp.load_dock_layout({"dictionary": "DICT_4X4_50", "markers": [marker]})
    level = {"x": 0.45, "y": 0.0, "z": 0.7, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    parameters = sp.default_parameters()
    # Cells of 6 and 7 px are no print that grey levels could be fitted to: by default, what they deviate makes the
    # corners less certain, and both solutions stay.
    corners, image = sp.default_parameters() | {"refinement": "corners_visp"}, marker_image(40)
    for kind in (sp.DockDetector, sp.DockTracker):
        weights, frontal = [], []
        for mount in (None, level, level | {"pitch": 0.3}):
            (seen,) = kind(camera(), layout, corners, mount).detect(image).markers
            weights.append(seen.hypotheses[1].weight)
            (seen,) = kind(camera(), layout, parameters, mount).detect(image).markers
            frontal += [h.weight for h in seen.hypotheses if h.pose[2, 2] < -0.99]
        assert weights[0] == weights[1] < 1e-12 < weights[2] < 1.0, weights
        assert 1.0 > frontal[0] == frontal[1] > frontal[2] + 0.05, frontal
        with pytest.raises(sp.ConfigurationError, match=r"camera/pitch: .*9"):
            kind(camera(), layout, parameters, level | {"pitch": 9.0})
        with pytest.raises(sp.ConfigurationError, match="camera/yaw"):
            kind(camera(), layout, parameters, {key: value for key, value in level.items() if key != "yaw"})


def test_projection() -> None:
    pixels = camera().project(np.array([[0.1, -0.2, 2.0], [0.0, 0.0, -1.0]]))
    assert pixels[0] == pytest.approx([CX + 32.0, CY - 64.0])
    assert np.isnan(pixels[1]).all()


def test_photometric_refinement_finds_back_from_a_wrong_start() -> None:
    refiner = sp.PhotometricRefiner(sp.default_photometric_parameters())
    pattern = sp.MarkerFamily.named("DICT_4X4_50").pattern(3)
    z = F * 0.1 / 126
    start = np.diag([1.0, -1.0, -1.0, 1.0])  # marker facing the camera
    start[:3, 3] = [(562.5 - CX) * z / F + 0.0005, (362.5 - CY) * z / F, 1.004 * z]
    result = refiner.refine(marker_image(), camera(), [sp.PatternPlacement(pattern, 0.1)], start)
    assert result.converged, result.failure
    assert result.pose[:3, 3] == pytest.approx([(562.5 - CX) * z / F, (362.5 - CY) * z / F, z], abs=3e-4)


def test_files_of_the_configuration_are_read() -> None:
    parameters = yaml.safe_load((CONFIG / "perception.yaml").read_text())
    layout = sp.load_dock_layout(yaml.safe_load((CONFIG / "docks" / "default.yaml").read_text()))
    assert parameters.keys() == sp.default_parameters().keys()
    assert sp.DockDetector(camera(), layout, parameters).detect(marker_image()).markers == []


@pytest.mark.parametrize("value", ["12", 1e9, None, [1]])
def test_wrong_parameter_is_named(value: object) -> None:
    parameters = sp.default_parameters()
    parameters["detector"]["min_side"] = value
    with pytest.raises(sp.ConfigurationError, match="perception/detector/min_side"):
        sp.DockDetector(camera(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1), parameters)


def test_images_of_another_process_are_taken() -> None:
    """What was pickled has a dtype object of its own."""
    detector = sp.DockDetector(camera(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1), sp.default_parameters())
    image = pickle.loads(pickle.dumps(marker_image()))
    assert image.dtype is not marker_image().dtype
    assert [m.id for m in detector.detect(image).markers] == [3]


def test_wrong_images_are_refused() -> None:
    detector = sp.DockDetector(camera(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1), sp.default_parameters())
    with pytest.raises(sp.ImageError):
        detector.detect(np.zeros((480, 640), np.uint8))
    for wrong in (np.zeros((720, 1280), np.float32), np.zeros((720, 1280, 3), np.uint8), marker_image()[:, ::2]):
        with pytest.raises(TypeError, match="image"):
            detector.detect(wrong)


def test_threads_that_share_one_detector_get_what_one_thread_gets() -> None:
    images = [marker_image(size) for size in (30, 62, 126)]
    parameters, layout = sp.default_parameters(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1)

    def found(detector: sp.DockDetector, image: np.ndarray) -> list[tuple[bytes, ...]]:
        return [
            (m.corners.tobytes(), m.hypotheses[0].pose.tobytes(), m.covariance.tobytes())
            for m in detector.detect(image).markers
        ]

    expected = [found(sp.DockDetector(camera(), layout, parameters), image) for image in images]
    assert all(expected)
    shared = sp.DockDetector(camera(), layout, parameters)
    jobs = [images[k % 3] for k in range(36)]
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(lambda image: found(shared, image), jobs))
    assert results == [expected[k % 3] for k in range(36)]


def test_other_threads_run_during_a_detection() -> None:
    detector = sp.DockDetector(camera(), sp.layout_of_equal_markers("DICT_4X4_50", 0.1), sp.default_parameters())
    image, busy = marker_image(), threading.Event()
    ticks_within = 0
    ready = threading.Event()

    def detect() -> None:
        ready.set()
        for _ in range(20):
            detector.detect(image)
        busy.set()

    thread = threading.Thread(target=detect)
    thread.start()
    ready.wait()
    while not busy.wait(0.001):
        ticks_within += 1
    thread.join()
    assert ticks_within > 20  # with the lock held there would be about one for each detection at most


def test_every_parameter_is_described() -> None:
    def keys(values: dict, path: str = "") -> list[str]:
        inner = [keys(value, f"{path}{name}/") if isinstance(value, dict) else [] for name, value in values.items()]
        return [key for name, below in zip(values, inner, strict=True) for key in (path + name, *below)]

    described = sp.describe_parameters()
    assert [entry["key"] for entry in described] == keys(sp.default_parameters())
    (size,) = (entry for entry in described if entry["key"] == "detector/min_side")
    assert (size["default"], size["unit"], size["low"], size["high"]) == (11.0, "px", 5.0, 500.0)
    assert size["text"]
