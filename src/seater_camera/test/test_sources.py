"""The sources: which clock, which lens, what is said when they cannot be had."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from stand_ins import Capture, RealSense
from virtual import picture

from seater_camera.frames import Clock, EndOfStreamError, SourceError
from seater_camera.settings import CameraSettings, FormatSettings
from seater_camera.sources import realsense
from seater_camera.sources.kinds import make_source
from seater_camera.sources.realsense import RealsenseSource
from seater_camera.sources.recorded import RecordedSource
from seater_camera.sources.v4l2 import V4l2Source
from seater_common.params import ParameterError

SETTINGS = CameraSettings(format=FormatSettings(width=64, height=48))


def v4l2(capture: Capture, device: str = "") -> V4l2Source:
    return V4l2Source(replace(SETTINGS, device=device), capture)


@pytest.mark.parametrize(
    ("seconds", "clock"),
    [
        (lambda: time.monotonic() - 0.02, Clock.MONOTONIC),
        (lambda: time.time() - 0.02, Clock.WALL),
        (lambda: 77.0 + 1e7, Clock.DEVICE),
        (lambda: 0.0, Clock.ARRIVAL),
    ],
)
def test_v4l2_tells_which_clock_the_driver_used(seconds: Callable[[], float], clock: Clock) -> None:
    times = [seconds(), seconds() - 60.0]  # the second one has waited for a minute: the clock is the same
    source = v4l2(Capture(times=list(times)))
    source.open()
    frames = [source.read() for _ in times]
    assert [frame.clock for frame in frames] == [clock, clock]
    assert [frame.time for frame in frames] == pytest.approx(times)
    assert frames[0].arrival == pytest.approx(time.monotonic(), abs=1.0)


def test_v4l2_asks_for_format_size_and_rate() -> None:
    capture = Capture()
    v4l2(capture).open()
    assert capture.controls == {
        cv2.CAP_PROP_FOURCC: cv2.VideoWriter.fourcc(*"MJPG"),
        cv2.CAP_PROP_FRAME_WIDTH: 64,
        cv2.CAP_PROP_FRAME_HEIGHT: 48,
        cv2.CAP_PROP_FPS: 30,
    }


def test_v4l2_of_another_size_names_both_and_is_closed() -> None:
    capture = Capture(size=(32, 24))
    with pytest.raises(SourceError, match=r"32 x 24 pixels, 64 x 48 are asked for"):
        v4l2(capture).open()
    assert capture.released


def test_v4l2_unplugged_says_so() -> None:
    source = v4l2(Capture(times=[1.0]), "/dev/no_such_camera")
    source.open()
    source.read()
    with pytest.raises(SourceError, match="no_such_camera gives no more images: there is no such device"):
        source.read()
    with pytest.raises(SourceError, match="is the camera plugged in"):
        v4l2(Capture(there=False), "/dev/no_such_camera").open()


def test_v4l2_with_opencv_itself() -> None:
    with pytest.raises(SourceError, match="there is no such device"):
        V4l2Source(replace(SETTINGS, device="/dev/no_such_camera")).open()


def test_v4l2_exposure_is_in_units_of_100_microseconds() -> None:
    capture = Capture()
    source = v4l2(capture)
    source.open()
    assert source.set_exposure(0.005)
    assert (capture.controls[cv2.CAP_PROP_AUTO_EXPOSURE], capture.controls[cv2.CAP_PROP_EXPOSURE]) == (1, 50)
    assert source.set_exposure(None)
    assert capture.controls[cv2.CAP_PROP_AUTO_EXPOSURE] == 3


def test_realsense_gives_lens_and_clock() -> None:
    library = RealSense([(1e12, "global"), (5e5, "hardware"), (1e12, "system")])
    source = RealsenseSource(replace(SETTINGS, device="123"), library)
    lens = source.open()
    assert lens is not None and (lens.width, lens.height, lens.K[0, 0], lens.K[1, 2]) == (64, 48, 50.0, 24.0)
    assert not lens.distorted
    assert library.asked == ["123", ("color", 64, 48, "bgr8", 30)]
    frames = [source.read() for _ in range(3)]
    assert [f.clock for f in frames] == [Clock.WALL, Clock.DEVICE, Clock.WALL]
    assert frames[1].time == pytest.approx(500.0)
    assert source.set_exposure(0.005)
    assert library.sensor.options == {"enable_auto_exposure": 0.0, "exposure": pytest.approx(50.0)}
    with pytest.raises(SourceError, match="plugged in"):
        source.read()
    source.close()
    assert not library.running


def test_realsense_with_a_distortion_of_its_own_tells_no_lens() -> None:
    library = RealSense([(1e12, "global")])
    library.intrinsics.coeffs = [0.1, 0.0, 0.0, 0.0, 0.0]
    assert RealsenseSource(SETTINGS, library).open() is None


def test_realsense_that_is_not_there() -> None:
    with pytest.raises(SourceError, match="No device connected"):
        RealsenseSource(SETTINGS, RealSense([])).open()


def test_realsense_without_its_library_names_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ImportError(f"No module named {name!r}")

    monkeypatch.setattr(realsense.importlib, "import_module", absent)
    with pytest.raises(ParameterError, match=r"pip install -r tools/requirements_realsense.txt"):
        make_source("realsense", SETTINGS)
    assert (Path(__file__).resolve().parents[3] / "tools" / "requirements_realsense.txt").is_file()


def test_the_library_of_realsense_has_what_is_used() -> None:
    rs = pytest.importorskip("pyrealsense2", reason="optional: tools/requirements_realsense.txt")
    for group in ("stream", "format", "timestamp_domain", "option"):
        for name in vars(getattr(RealSense, group)):
            assert hasattr(getattr(rs, group), name), f"{group}.{name}"
    for name in ("enable_device", "enable_stream"):
        assert hasattr(rs.config, name)
    for name in ("start", "stop", "wait_for_frames"):
        assert hasattr(rs.pipeline, name)
    found = rs.intrinsics()
    found.width, found.height, found.fx, found.fy, found.ppx, found.ppy = 64, 48, 50.0, 51.0, 32.0, 24.0
    found.model, found.coeffs = rs.distortion.inverse_brown_conrady, [0.0] * 5
    lens = realsense._lens(found)
    assert lens is not None and lens.K[0, 0] == 50.0
    with pytest.raises(SourceError, match="cannot be opened"):
        RealsenseSource(replace(SETTINGS, device="0"), rs).open()


def test_a_folder_is_played_once_at_its_pace(tmp_path: Path) -> None:
    for n in range(4):
        cv2.imwrite(str(tmp_path / f"{n}.png"), picture(n))
    source = RecordedSource(replace(SETTINGS, device=str(tmp_path), format=replace(SETTINGS.format, rate=50)))
    source.open()
    begin = time.monotonic()
    frames = [source.read() for _ in range(4)]
    assert time.monotonic() - begin >= 0.06
    assert [frame.time for frame in frames] == pytest.approx([0.0, 0.02, 0.04, 0.06])
    assert all(np.array_equal(frame.image, picture(n)) for n, frame in enumerate(frames))
    with pytest.raises(EndOfStreamError, match="has ended after 4 images"):
        source.read()
    source.close()
    with pytest.raises(EndOfStreamError):
        source.open()


def test_a_video_is_played(tmp_path: Path) -> None:
    file = tmp_path / "drive.avi"
    video = cv2.VideoWriter(str(file), cv2.VideoWriter.fourcc(*"MJPG"), 100.0, (64, 48))
    for n in range(3):
        video.write(picture(n))
    video.release()
    source = make_source("recorded", replace(SETTINGS, device=str(file)))
    source.open()
    assert [source.read().time for _ in range(3)] == pytest.approx([0.0, 0.01, 0.02])
    with pytest.raises(EndOfStreamError):
        source.read()


def test_recordings_that_are_none(tmp_path: Path) -> None:
    for device in ("", str(tmp_path), str(tmp_path / "no.avi")):
        with pytest.raises(ParameterError):
            make_source("recorded", replace(SETTINGS, device=device))
    with pytest.raises(ParameterError, match="must be one of v4l2, realsense, recorded"):
        make_source("webcam", SETTINGS)
