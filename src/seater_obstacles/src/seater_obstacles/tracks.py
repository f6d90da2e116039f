"""Clusters followed over a short time: which move, and how fast."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seater_obstacles.settings import TrackSettings

Array = NDArray[np.float64]

_POSITION_SD = 0.06  # [m] of a cluster's middle: other parts of the thing are seen from elsewhere
_SPEED_SD = 1.0  # [m/s] of a thing seen for the first time: a walk
_ACCELERATION = 1.0  # [m/s^2] of somebody who starts, stops or turns
_LOST = 0.5  # [s] without being seen after which a track ends
_HITS = 3  # times that a thing is seen before it moves
_CERTAIN = 2.5  # standard deviations by which its speed differs from zero


class Track:
    """One thing: a Kalman filter of constant velocity, both axes alike (P of position and speed, 2x2)."""

    def __init__(self, stamp: float, position: Array) -> None:
        self.stamp, self.seen, self.hits = stamp, stamp, 1
        self.position, self.velocity = position.copy(), np.zeros(2)
        self._P = np.diag([_POSITION_SD**2, _SPEED_SD**2])

    def predict(self, stamp: float) -> None:
        """Forward to `stamp` [s]."""
        dt = stamp - self.stamp
        F = np.array([[1.0, dt], [0.0, 1.0]])
        G = np.array([0.5 * dt * dt, dt])
        self.position = self.position + dt * self.velocity
        self._P = F @ self._P @ F.T + _ACCELERATION**2 * np.outer(G, G)
        self.stamp = stamp

    def update(self, position: Array) -> None:
        """The cluster's middle (2,) [m] at the stamp."""
        K = self._P[:, 0] / (self._P[0, 0] + _POSITION_SD**2)
        innovation = position - self.position
        self.position = self.position + K[0] * innovation
        self.velocity = self.velocity + K[1] * innovation
        self._P = self._P - np.outer(K, self._P[0])
        self.seen, self.hits = self.stamp, self.hits + 1

    def moves(self, speed: float) -> bool:
        """Surely, and faster than `speed` [m/s]."""
        v = float(np.hypot(*self.velocity))
        return self.hits >= _HITS and v > speed and v > _CERTAIN * float(np.sqrt(self._P[1, 1]))


class Tracks:
    """All things that are small enough to move."""

    def __init__(self, settings: TrackSettings) -> None:
        self._settings = settings
        self._tracks: list[Track] = []

    def update(self, stamp: float, middles: list[Array]) -> list[Track]:
        """The track of each cluster, whose middles (2,) [m] in odom were seen at `stamp` [s]; nearest pairs first."""
        if self._tracks and stamp < self._tracks[0].stamp:
            self._tracks = []
        for track in self._tracks:
            track.predict(stamp)
        found: dict[int, Track] = {}
        taken: set[int] = set()
        for i, j in self._pairs(middles):
            if i not in found and j not in taken:
                self._tracks[j].update(middles[i])
                found[i] = self._tracks[j]
                taken.add(j)
        for i in range(len(middles)):
            if i not in found:
                found[i] = Track(stamp, middles[i])
                self._tracks.append(found[i])
        self._tracks = [track for track in self._tracks if stamp - track.seen <= _LOST]
        return [found[i] for i in range(len(middles))]

    def _pairs(self, middles: list[Array]) -> list[tuple[int, int]]:
        """(cluster, track) within the largest jump, the nearest first."""
        near = [
            (float(np.hypot(*(middle - track.position))), i, j)
            for i, middle in enumerate(middles)
            for j, track in enumerate(self._tracks)
        ]
        return [(i, j) for distance, i, j in sorted(near) if distance <= self._settings.max_jump]
