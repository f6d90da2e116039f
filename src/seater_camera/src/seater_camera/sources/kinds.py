"""The kinds of sources, by name."""

from __future__ import annotations

from collections.abc import Callable

from seater_camera.frames import Source
from seater_camera.settings import CameraSettings
from seater_camera.sources.realsense import RealsenseSource
from seater_camera.sources.recorded import RecordedSource
from seater_camera.sources.v4l2 import V4l2Source
from seater_common.params import ParameterError

KINDS: dict[str, Callable[[CameraSettings], Source]] = {
    "v4l2": V4l2Source,
    "realsense": RealsenseSource,
    "recorded": RecordedSource,
}


def make_source(kind: str, settings: CameraSettings) -> Source:
    """Raises ParameterError: no such kind, or it cannot be used here."""
    if kind not in KINDS:
        raise ParameterError(f"source: is {kind!r}, must be one of {', '.join(KINDS)}")
    return KINDS[kind](settings)
