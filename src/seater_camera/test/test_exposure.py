"""The exposure: white of the prints not cut off, no leap, no more than a moving chair allows."""

from dataclasses import replace

import numpy as np
import pytest

from seater_camera.exposure import ExposureController, Light
from seater_camera.settings import ExposureSettings

SETTINGS = ExposureSettings()


def scene(exposure: float, gain: float) -> np.ndarray:
    """A dark room with a print: black 10, white 90 at 1 ms and gain 1; cut off at 255."""
    light = np.full((72, 128), 20.0)
    light[20:50, 40:90] = 90.0
    light[30:40, 55:75] = 10.0
    light += np.random.default_rng(1).normal(0.0, 2.0, light.shape)
    return np.clip(light * 1e3 * exposure * gain, 0, 255).astype(np.uint8)


def settle(controller: ExposureController, gain: float, seconds: int = 40, told: bool = False) -> list[float]:
    times = []
    for second in range(seconds):
        image = scene(controller.time, gain)
        if told:
            controller.told(float(np.mean(image[20:50, 40:90] == 255)), float(second))
        controller.decide(Light.of(image), float(second))
        times.append(controller.time)
    return times


@pytest.mark.parametrize("gain", [0.3, 1.0, 3.0, 8.0])
def test_ends_with_white_bright_and_not_cut_off(gain: float) -> None:
    controller = ExposureController(SETTINGS)
    times = settle(controller, gain)
    image = scene(controller.time, gain)
    assert np.mean(image[20:30, 40:90] == 255) <= 0.06
    assert np.percentile(image, 99) > 150.0
    assert len(set(times[-10:])) == 1, "does not swing"


def test_dark_ends_at_the_longest_and_is_said() -> None:
    controller = ExposureController(SETTINGS)
    assert settle(controller, 0.05)[-1] == SETTINGS.longest
    assert controller.too_dark


def test_glare_ends_at_the_shortest() -> None:
    assert settle(ExposureController(SETTINGS), 200.0)[-1] == SETTINGS.shortest


def test_steps_are_small_but_where_nearly_all_is_cut_off() -> None:
    controller = ExposureController(SETTINGS)
    steps = np.diff(np.log(settle(controller, 0.3)))
    assert np.abs(steps).max() <= np.log(1.25) + 1e-9
    controller = ExposureController(SETTINGS)
    assert np.exp(np.diff(np.log(settle(controller, 8.0)))).min() == pytest.approx(0.5)


def test_perceptions_word_counts_before_a_lamp_in_the_image() -> None:
    lamp = Light(bright=255.0, clipped=0.9)
    controller = ExposureController(SETTINGS)
    controller.told(0.0, 0.0)
    assert controller.decide(lamp, 0.5) is None
    assert controller.decide(lamp, 10.0) is not None  # perception has fallen silent


def test_decides_once_per_second() -> None:
    controller = ExposureController(SETTINGS)
    lamp = Light(bright=255.0, clipped=0.9)
    assert [controller.decide(lamp, t) is not None for t in (0.0, 0.5, 0.99, 1.0)] == [True, False, False, True]


def test_limits_the_wrong_way_round_are_refused() -> None:
    with pytest.raises(ValueError, match="must be <= longest"):
        replace(SETTINGS, shortest=0.05)
