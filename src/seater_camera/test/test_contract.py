"""What every camera has to keep, for a virtual one as for one that is plugged in (`--hardware v4l2:/dev/video0`)."""

import threading
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from virtual import picture

from seater_camera.clock.stamps import Stamper
from seater_camera.frames import Clock, Frame, Source
from seater_camera.settings import CameraSettings, ClockSettings
from seater_camera.sources.kinds import make_source
from seater_camera.stream import Stream

SECONDS = 2.0  # of images that are looked at


class LiveVirtual:
    """A camera of 30 Hz in true time, whose own clock began elsewhere and runs 80 ppm too fast."""

    name, clock_period = "virtual", float("inf")

    def open(self) -> None:
        self._begin, self._count = time.monotonic(), 0

    def read(self) -> Frame:
        taken = self._begin + self._count / 30.0
        self._count += 1
        time.sleep(max(0.0, taken + 0.01 - time.monotonic()))
        return Frame(picture(self._count, 720, 1280), 50.0 + 1.00008 * taken, Clock.DEVICE, time.monotonic())

    def close(self) -> None:
        return

    def set_exposure(self, seconds: float | None) -> bool:
        return True


@pytest.fixture(params=["virtual", "hardware"])
def camera(request: pytest.FixtureRequest) -> Iterator[tuple[Source, CameraSettings]]:
    settings = CameraSettings(clock=ClockSettings(max_age=1.0))
    if request.param == "virtual":
        yield LiveVirtual(), settings
        return
    told = request.config.getoption("--hardware")
    if not told:
        pytest.skip("no --hardware")
    kind, _, device = told.partition(":")
    yield make_source(kind, replace(settings, device=device)), settings


def test_images_come_once_in_time_and_in_order(camera: tuple[Source, CameraSettings]) -> None:
    source, settings = camera
    stamps, at, images = [], [], []

    def take(image: np.ndarray, stamp: float, _: object) -> None:
        stamps.append(stamp)
        at.append(time.time())
        images.append(image.tobytes())

    stream = Stream(source, settings, Stamper(settings.clock), take)
    thread = threading.Thread(target=stream.run)
    thread.start()
    deadline = time.monotonic() + 30.0
    while (not stamps or stamps[-1] - stamps[0] < SECONDS) and time.monotonic() < deadline:
        time.sleep(0.05)
    stream.stop()
    thread.join(15.0)
    assert not thread.is_alive()
    assert len(stamps) > 10, stream.health.complaint(stream.health.report(time.monotonic()))
    assert np.all(np.diff(stamps) > 0.0)
    ages = np.array(at) - stamps
    assert np.all(ages >= 0.0) and ages.max() < settings.clock.max_age + 0.1
    assert len(set(images)) == len(images)
    assert np.median(np.diff(stamps)) == pytest.approx(1.0 / settings.format.rate, rel=0.2)
