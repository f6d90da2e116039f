"""Blur, noise, vignetting, gain and motion blur have the statistics that their parameters say."""

import numpy as np
import pytest

from seater_common.camera_model import CameraModel
from seater_common.geometry import Chair, Dock
from seater_sim.camera.camera import Camera
from seater_sim.camera.sensor import Sensor
from seater_sim.settings import CameraSettings

FLAT = np.full((720, 1280), 120, np.uint8)


def settings(**changes: float) -> CameraSettings:
    ideal = {"blur_sd": 0.0, "noise_sd": 0.0, "vignetting": 0.0, "exposure": 0.0}
    return CameraSettings(**(ideal | changes))  # type: ignore[arg-type]


def step_of(profile: np.ndarray) -> tuple[float, float]:
    """Place and variance [px, px^2] of the step in a brightness profile (n,), from its first differences."""
    weights = np.diff(profile.astype(float))
    weights = weights / weights.sum()
    at = np.arange(len(weights)) + 0.5
    mean = float(np.sum(weights * at))
    return mean, float(np.sum(weights * (at - mean) ** 2))


@pytest.mark.parametrize("sd", [0.5, 2.0, 5.0])
def test_noise_is_white_with_the_right_sd(sd: float) -> None:
    sensor = Sensor(settings(noise_sd=sd), 1280, 720)
    noise = sensor.expose(FLAT, 1, 1).astype(float) - 120.0
    assert noise.std() == pytest.approx(np.hypot(sd, np.sqrt(1 / 12)), rel=0.02)  # whole grey levels
    assert abs(noise.mean()) < 0.02
    for shift, axis in [(1, 0), (1, 1), (7, 1)]:
        assert abs(np.mean(noise * np.roll(noise, shift, axis))) / noise.var() < 0.005  # 5 sd of 0.9 million pixels


def test_noise_differs_between_images_and_seeds_and_repeats() -> None:
    sensor = Sensor(settings(noise_sd=2.0), 1280, 720)
    one = sensor.expose(FLAT, 1, 1)
    assert np.array_equal(one, sensor.expose(FLAT, 1, 1))
    for seed, index in [(1, 2), (2, 1), (1, 300)]:
        other = sensor.expose(FLAT, seed, index)
        correlation = np.corrcoef(one.ravel(), other.ravel())[0, 1]
        assert abs(correlation) < 0.005


def test_noise_saturates_without_wrapping() -> None:
    sensor = Sensor(settings(noise_sd=20.0), 1280, 720)
    dark, bright = (sensor.expose(np.full((720, 1280), level, np.uint8), 1, 1) for level in (2, 253))
    assert dark.max() < 150 and bright.min() > 100


def test_vignetting_and_gain() -> None:
    image = Sensor(settings(vignetting=0.4, gain=1.5), 1280, 720).expose(FLAT, 1, 1).astype(float)
    assert image[360, 640] == pytest.approx(180.0, abs=1.0)
    assert image[0, 0] == pytest.approx(108.0, abs=1.5)  # 1.5 * 0.6 * 120
    assert image[0, 640] == pytest.approx(180.0 * (1.0 - 0.4 * 720**2 / (720**2 + 1280**2)), abs=1.5)
    assert Sensor(settings(gain=3.0), 1280, 720).expose(FLAT, 1, 1).max() == 255


def test_colour_noise_is_independent_between_the_channels() -> None:
    sensor = Sensor(settings(noise_sd=3.0), 1280, 720)
    noise = sensor.expose(np.dstack([FLAT] * 3), 1, 1).astype(float) - 120.0
    assert abs(np.corrcoef(noise[:, :, 0].ravel(), noise[:, :, 1].ravel())[0, 1]) < 0.005
    assert noise.std() == pytest.approx(3.0, rel=0.02)


@pytest.mark.parametrize("sd", [0.7, 1.5])
def test_blur_of_a_rendered_edge(model: CameraModel, sd: float) -> None:
    camera = Camera(model, Chair().camera, Dock(), settings(blur_sd=sd))
    pose = (0.0, 0.0, 0.0)
    corners = camera.marker_corners(pose)[0]
    rows = slice(int(corners[0, 1]) + 10, int(corners[3, 1]) - 10)
    left = int(corners[0, 0])
    profile = camera.render(pose)[rows, left - 9 : left + 10].mean(axis=0)
    place, variance = step_of(profile)
    assert left - 9 + place == pytest.approx(corners[0, 0], abs=0.03)
    # The pixel's box and the two samples' ramp (1/2 px) add to the Gaussian, which OpenCV cuts at 3 sd.
    assert variance == pytest.approx(sd**2 + 1 / 12 + 1 / 48, rel=0.06)


def test_motion_blur_is_as_long_as_the_motion(model: CameraModel) -> None:
    camera = Camera(model, Chair().camera, Dock(), settings(exposure=0.010))
    pose, omega = (-0.3, 0.0, 0.0), 0.8
    corners = camera.marker_corners(pose)[0]
    ends = [camera.marker_corners((pose[0], pose[1], s * omega * 0.005))[0] for s in (-1.0, 1.0)]
    length = abs(float(ends[1][0, 0] - ends[0][0, 0]))
    assert length > 5.0
    rows = slice(int(corners[0, 1]) + 10, int(corners[3, 1]) - 10)
    left = int(corners[0, 0])  # the border is 14 px wide, so its inner edge stays out of the profile
    blurred = camera.render(pose, 0.0, omega)[rows, left - 9 : left + 10].mean(axis=0)
    place, variance = step_of(blurred)
    assert left - 9 + place == pytest.approx(corners[0, 0], abs=0.1)  # the stamp is the middle of the exposure
    assert variance == pytest.approx(length**2 / 12 + 1 / 12, rel=0.08)
    still = camera.render(pose)[rows, left - 9 : left + 10].mean(axis=0)
    assert step_of(still)[1] < 0.4


def test_same_seed_same_bytes(camera: Camera) -> None:
    one = camera.render((-1.0, 0.1, 0.05), 0.2, 0.1, seed=4, index=9)
    assert one.tobytes() == camera.render((-1.0, 0.1, 0.05), 0.2, 0.1, seed=4, index=9).tobytes()
    assert one.tobytes() != camera.render((-1.0, 0.1, 0.05), 0.2, 0.1, seed=5, index=9).tobytes()
    assert one.tobytes() != camera.render((-1.0, 0.1, 0.05), 0.2, 0.1, seed=4, index=10).tobytes()
