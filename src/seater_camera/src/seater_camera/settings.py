"""Everything a person tunes about the camera driver (config/camera.yaml)."""

from __future__ import annotations

from dataclasses import dataclass, field

from seater_common.params import param


@dataclass(frozen=True)
class FormatSettings:
    """What the camera is asked for."""

    width: int = param(1280, "px", "of the image, as in the calibration", low=16, high=8192)
    height: int = param(720, "px", "of the image, as in the calibration", low=16, high=8192)
    rate: int = param(30, "Hz", "images per second", low=1, high=240)
    pixels: str = param(
        "MJPG", "", "V4L2 pixel format; YUYV: without JPEG, needs USB 3", choices=("MJPG", "YUYV", "GREY", "any")
    )
    encoding: str = param(
        "mono8", "", "of image_raw: grey is all that markers need; bgr8: colours", choices=("mono8", "bgr8")
    )


@dataclass(frozen=True)
class ClockSettings:
    """How the time of an image's exposure is found."""

    delay: float = param(0.0, "s", "how long after its exposure the camera times an image", low=0.0, high=0.2)
    max_age: float = param(0.5, "s", "an image that arrives older than this is not published", low=0.05, high=10.0)


@dataclass(frozen=True)
class ExposureSettings:
    """Who sets the exposure, and so that the white of the prints is not cut off."""

    mode: str = param(
        "prints",
        "",
        "prints: by the white round the markers; device: the camera's own; fixed: `time`",
        choices=("prints", "device", "fixed"),
    )
    time: float = param(0.005, "s", "at the start, and with `fixed` for ever", low=1e-5, high=0.1)
    longest: float = param(0.010, "s", "a longer one blurs the image of a chair that drives", low=1e-4, high=0.1)
    shortest: float = param(0.0002, "s", "a shorter one flickers under lamps", low=1e-5, high=0.1)
    most_clipped: float = param(0.05, "", "share of the prints' white that may be cut off", low=0.001, high=0.5)
    white: float = param(200.0, "", "grey level that the brightest part of the image gets at least", low=50, high=250)

    def __post_init__(self) -> None:
        if self.shortest > self.longest:
            raise ValueError(f"shortest is {self.shortest}, must be <= longest ({self.longest})")


@dataclass(frozen=True)
class CameraSettings:
    """The whole of config/camera.yaml."""

    device: str = param("", "", "V4L2: /dev/video0; RealSense: serial number; empty: the first one")
    timeout: float = param(2.0, "s", "without an image the camera is opened anew", low=0.2, high=60.0)
    format: FormatSettings = field(default_factory=FormatSettings)
    clock: ClockSettings = field(default_factory=ClockSettings)
    exposure: ExposureSettings = field(default_factory=ExposureSettings)
