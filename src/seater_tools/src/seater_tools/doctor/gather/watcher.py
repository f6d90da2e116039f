"""Collects what arrives, message by message; the newest images are looked at in the end. One lock: callbacks of several
topics come in threads of their own."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Dock
from seater_tools.doctor.gather.image import Image, other_markers, white_of
from seater_tools.doctor.observations import GateSeen, Live, ObstaclesSeen, Pictures, Sight, Traffic

Array = NDArray[np.float64]

KEPT_IMAGES = 40  # newest: perception's answer to an image comes later than the image
LOOKED_AT = 5  # images for exposure
SAME_STAMP = 1e-4  # [s]


@dataclass
class _Newest:
    """Of what says the same again and again."""

    gate: GateSeen | None = None
    emergency_stop: bool | None = None
    contact: bool | None = None
    info: CameraModel | None = None
    info_error: str = ""
    size: tuple[int, int] | None = None
    image_frame: str = ""
    frames: tuple[str, str] = ("", "")
    blocked: str = ""  # of the obstacle finder


class Watcher:
    """`arrived` for every message, and beside it what the message says."""

    def __init__(self) -> None:
        self.newest = _Newest()
        self._lock = threading.Lock()
        self._times: dict[str, list[tuple[float, float]]] = {}
        self._odometry: list[tuple[float, ...]] = []
        self._sights: list[Sight] = []
        self._images: deque[tuple[float, Image]] = deque(maxlen=KEPT_IMAGES)
        self._joystick: list[tuple[float, float]] = []
        self._complaints: dict[str, str] = {}

    def arrived(self, role: str, stamp: float, now: float) -> None:
        """A message of this topic; `stamp` NaN: it has none. Both [s] of the ROS clock."""
        with self._lock:
            self._times.setdefault(role, []).append((stamp, now))

    def odometry(self, row: tuple[float, float, float, float, float, float]) -> None:
        """stamp, x, y [m], heading [rad], v [m/s], omega [rad/s]."""
        with self._lock:
            self._odometry.append(row)

    def sight(self, sight: Sight) -> None:
        """One image worked through."""
        with self._lock:
            self._sights.append(sight)

    def image(self, stamp: float, grey: Image) -> None:
        """(height, width) as it came."""
        with self._lock:
            self._images.append((stamp, grey))
            self.newest.size = (grey.shape[1], grey.shape[0])

    def joystick(self, v: float, omega: float) -> None:
        """As it asks."""
        with self._lock:
            self._joystick.append((v, omega))

    def complaint(self, node: str, text: str) -> None:
        """An error on /diagnostics, the newest of each node is kept."""
        with self._lock:
            self._complaints[node] = text

    def obstacles(self, kind: str, topics: tuple[Traffic, ...]) -> ObstaclesSeen:
        """`topics` of the sensor."""
        with self._lock:
            times = np.array(self._times.get("obstacle_points", []), dtype=float).reshape(-1, 2)
            return ObstaclesSeen(kind, topics, times[:, 1], self.newest.blocked)

    def since(self, begin: float) -> tuple[Array, list[Sight]]:
        """Odometry (n, 6) and sights with stamps from `begin` [s] on."""
        with self._lock:
            rows = np.array([row for row in self._odometry if row[0] >= begin], dtype=float).reshape(-1, 6)
            return rows, [sight for sight in self._sights if sight.stamp >= begin]

    def live(self, base: Live, topics: Mapping[str, Traffic], dock: Dock | None) -> Live:
        """`base` with all that has arrived so far; `topics`: who sends and who listens."""
        with self._lock:
            odometry = np.array(self._odometry, dtype=float).reshape(-1, 6)
            traffic = {role: self._with_times(role, topic) for role, topic in topics.items()}
            return replace(
                base,
                topics=traffic,
                pictures=self._pictures(dock),
                sights=tuple(self._sights),
                odometry=odometry,
                frames=self.newest.frames,
                gate=self.newest.gate,
                emergency_stop=self.newest.emergency_stop,
                contact=self.newest.contact,
                joystick=np.array(self._joystick, dtype=float).reshape(-1, 2),
                complaints=tuple(self._complaints.items()),
            )

    def _with_times(self, role: str, topic: Traffic) -> Traffic:
        rows = np.array(self._times.get(role, []), dtype=float).reshape(-1, 2)
        return replace(topic, stamps=rows[:, 0], arrivals=rows[:, 1])

    def _pictures(self, dock: Dock | None) -> Pictures:
        newest, cut_off, contrast, other = self.newest, None, None, None
        whites = [white for white in map(self._white, list(self._images)[-2 * LOOKED_AT :]) if white is not None]
        if whites:
            cut_off, contrast = (float(value) for value in np.median(np.array(whites[-LOOKED_AT:]), axis=0))
        elif dock is not None and self._images and not any(sight.markers for sight in self._sights):
            other = other_markers(self._images[-1][1], dock.dictionary, [marker.id for marker in dock.markers])
        return Pictures(newest.size, newest.image_frame, newest.info, newest.info_error, cut_off, contrast, other)

    def _white(self, taken: tuple[float, Image]) -> tuple[float, float] | None:
        """Of an image, by the markers that perception found in it."""
        stamp, grey = taken
        sight = next((one for one in reversed(self._sights) if abs(one.stamp - stamp) < SAME_STAMP), None)
        if sight is None or not sight.markers:
            return None
        return white_of(grey, [marker.corners for marker in sight.markers])
