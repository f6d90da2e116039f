"""Exposure time by the white of the prints: not cut off, and bright enough."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_camera.settings import ExposureSettings

PERIOD = 1.0  # [s] between two changes: perception tells once per second, and cameras obey after some images
_TOLD = 2.5  # [s] that perception's word counts
_LARGEST_STEP = 1.25  # of a change, so that the grey levels of tracked markers do not leap
_MUCH, _MUCH_STEP = 0.5, 0.5  # where most of the white is cut off nobody knows by how much: half the time
_CALM = 0.8  # of most_clipped and of the way to `white`: nothing changes between
_BRIGHT = 99.0  # [%] of the image's pixels are darker than its "brightest part"
_STRIDE = 8  # every so manieth pixel of row and column is looked at


@dataclass(frozen=True)
class Light:
    """How bright an image is."""

    bright: float  # grey level that _BRIGHT of the pixels are below
    clipped: float  # share of the lighter pixels (from the middle between dark and bright on) that are cut off

    @classmethod
    def of(cls, image: NDArray[np.uint8]) -> Light:
        """Of an image (height, width) or (height, width, 3); its lightest channel counts."""
        part = image[::_STRIDE, ::_STRIDE]
        grey = part if part.ndim == 2 else part.max(axis=2)
        dark, bright = np.percentile(grey, (1.0, _BRIGHT))
        white = grey[grey >= 0.5 * (dark + bright)]
        return cls(float(bright), float(np.mean(white == 255)))


class ExposureController:
    """Decides on the exposure time once per second."""

    def __init__(self, settings: ExposureSettings) -> None:
        self._settings = settings
        self.time = float(np.clip(settings.time, settings.shortest, settings.longest))  # [s]
        self._told, self._told_at = 0.0, -math.inf
        self._decided_at = -math.inf
        self.clipped, self.bright = 0.0, math.nan  # what the last decision went by

    def told(self, clipped: float, now: float) -> None:
        """Perception's word: share of the white round markers that is cut off."""
        self._told, self._told_at = clipped, now

    def due(self, now: float) -> bool:
        """Whether a decision is; `now` [s] by a steady clock."""
        return now - self._decided_at >= PERIOD

    def decide(self, light: Light, now: float) -> float | None:
        """A new exposure time [s], or None: as it is.

        While perception sees markers, their white counts; else the brightest part of the image, a lamp too.
        """
        if not self.due(now):
            return None
        self._decided_at = now
        self.clipped = self._told if now - self._told_at <= _TOLD else light.clipped
        self.bright = light.bright
        wanted = float(np.clip(self.time * self._factor(), self._settings.shortest, self._settings.longest))
        if wanted == self.time:
            return None
        self.time = wanted
        return wanted

    def _factor(self) -> float:
        if self.clipped > _MUCH:
            return _MUCH_STEP
        if self.clipped > self._settings.most_clipped:
            return 1.0 / _LARGEST_STEP
        if self.clipped < _CALM * self._settings.most_clipped and self.bright < _CALM * self._settings.white:
            return min(_LARGEST_STEP, self._settings.white / max(self.bright, 1.0))
        return 1.0

    @property
    def too_dark(self) -> bool:
        """The longest exposure does not suffice: more light or gain is needed."""
        return self.time >= self._settings.longest and self.bright < 0.5 * self._settings.white
