"""The loop: every image once, silence when there is none, opened anew after whatever happens."""

from dataclasses import replace

import numpy as np
import pytest
from virtual import Time, VirtualSource, lens, picture, unplugged

from seater_camera import stream as stream_module
from seater_camera.clock.stamps import Refusal, Stamper
from seater_camera.frames import Clock, EndOfStreamError, Frame
from seater_camera.settings import CameraSettings, FormatSettings
from seater_camera.stream import Stream
from seater_common.camera_model import CameraModel

SETTINGS = CameraSettings(format=FormatSettings(width=64, height=48))


class Played:
    """A stream over a virtual source until its last frame."""

    def __init__(
        self, source: VirtualSource, settings: CameraSettings = SETTINGS, file: CameraModel | None = None
    ) -> None:
        time = source.time
        self.images: list[np.ndarray] = []
        self.stamps: list[float] = []
        self.at: list[float] = []  # wall time of each publication
        self.lenses: list[CameraModel | None] = []
        self.stamper = Stamper(settings.clock, steady=lambda: time.steady, wall=time.wall)
        self.stream = Stream(source, settings, self.stamper, self._take, lens=file, steady=lambda: time.steady)
        source.at_end = self.stream.stop
        self._wall = time.wall
        self.stream.run()
        self.health = self.stream.health
        assert not source.is_open
        self._check()

    def _take(self, image: np.ndarray, stamp: float, used: CameraModel | None) -> None:
        self.images.append(image)
        self.stamps.append(stamp)
        self.at.append(self._wall())
        self.lenses.append(used)

    def _check(self) -> None:
        """What holds whatever happens."""
        assert np.all(np.diff(self.stamps) > 0.0), "stamps go backwards"
        assert np.all(np.array(self.stamps) <= self.at), "a stamp of the future"
        assert len({image.tobytes() for image in self.images}) == len(self.images), "an image went out twice"


@pytest.fixture(autouse=True)
def no_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stream_module, "_FIRST_PAUSE", 0.001)
    monkeypatch.setattr(stream_module, "_LONGEST_PAUSE", 0.001)


@pytest.mark.parametrize("clock", list(Clock))
def test_every_image_goes_out_with_the_time_of_its_exposure(clock: Clock) -> None:
    source = VirtualSource(Time(), drift=80e-6, clock=clock)
    played = Played(source)
    assert len(played.images) == 300
    error = np.array(played.stamps) - source.time.wall_offset - source.taken
    late = {Clock.DEVICE: 0.020, Clock.ARRIVAL: 0.023}.get(clock, 0.0)  # what nobody can see from one side
    assert np.abs(np.median(error) - late) < 1e-3
    if clock is not Clock.ARRIVAL:
        assert np.std(error[30:]) < 0.3e-3
    assert played.images[0].ndim == 2
    assert played.health.report(source.time.steady).trouble == ""


def test_unplugged_and_plugged_in_again() -> None:
    source = VirtualSource(Time(), clock=Clock.MONOTONIC)
    source.script = {100: unplugged, 200: unplugged}
    played = Played(source)
    assert source.opened == 3
    assert len(played.images) == 298


def test_a_camera_that_stays_away_is_said_and_asked_again() -> None:
    source = VirtualSource(Time())
    source.frames, source.script = 5, dict.fromkeys(range(5), unplugged)
    played = Played(source)
    assert played.images == [] and source.opened == 5
    report = played.health.report(source.time.steady)
    assert played.health.complaint(report) == (True, "unplugged")


def test_a_stall_is_silence_and_no_old_image_comes_after_it() -> None:
    source = VirtualSource(Time(), clock=Clock.MONOTONIC)

    def stall(frame: Frame) -> Frame:
        source.time.steady += 3.0  # the frame waits in a buffer meanwhile
        return frame

    source.script = {100: stall}
    played = Played(source)
    assert played.health.total_refused[Refusal.OLD] == 1
    assert len(played.images) == 299
    assert np.max(np.array(played.at) - played.stamps) < 0.5
    period = float(np.median(np.diff(played.stamps)))
    assert played.health.total_dropped == pytest.approx(3.0 / period, abs=3)


def test_a_camera_that_repeats_its_last_image_is_silence() -> None:
    source = VirtualSource(Time())
    frozen = picture(1000)
    source.script = {n: lambda frame: replace(frame, image=frozen) for n in range(100, 200)}
    played = Played(source)
    assert len(played.images) == 201
    assert played.health.total_refused[Refusal.FROZEN] == 99


def test_an_image_of_another_size_is_never_published_and_both_sizes_are_named() -> None:
    source = VirtualSource(Time())
    source.frames = 50
    source.script = dict.fromkeys(range(50), lambda frame: replace(frame, image=frame.image[:24, :32]))
    played = Played(source)
    assert played.images == []
    text = played.health.complaint(played.health.report(source.time.steady))[1]
    assert "32 x 24" in text and "64 x 48" in text


def test_the_calibration_file_counts_before_the_device() -> None:
    file = lens()
    played = Played(VirtualSource(Time()), file=file)
    assert all(used is file for used in played.lenses)
    assert played.stream.lens_origin == "calibration file"
    assert Played(VirtualSource(Time(), device_lens=False)).lenses[0] is None


def test_the_end_of_a_recording_is_the_end() -> None:
    source = VirtualSource(Time())

    def end(_: Frame) -> Frame:
        raise EndOfStreamError("over")

    source.script = {10: end}
    played = Played(source)
    assert source.opened == 1 and len(played.images) == 10


def test_over_exposed_images_shorten_the_exposure() -> None:
    source = VirtualSource(Time(), clock=Clock.MONOTONIC)
    white = {
        n: lambda frame: replace(frame, image=np.maximum(frame.image, np.uint8(255)) - (frame.image > 250))
        for n in range(300)
    }
    source.script = white
    Played(source)
    assert source.exposures[0] == 0.005
    assert source.exposures[-1] is not None and source.exposures[-1] < 0.001


def test_the_devices_own_exposure_is_left_to_it() -> None:
    source = VirtualSource(Time())
    Played(source, replace(SETTINGS, exposure=replace(SETTINGS.exposure, mode="device")))
    assert source.exposures == [None]


def test_colours_where_they_are_asked_for() -> None:
    settings = replace(SETTINGS, format=replace(SETTINGS.format, encoding="bgr8"))
    assert Played(VirtualSource(Time()), settings).images[0].shape == (48, 64, 3)
