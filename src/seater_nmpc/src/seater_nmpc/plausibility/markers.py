"""Markers against each other and against the floor: print scale, places at the dock, tilt and height of the mount.

Each image shows its markers' centres, whatever pose of the dock is made of them. Their distances from each other are
those of the dock's file times the scale of the prints. Laid into the dock's frame, less shift, turn and scale, each
must be at its place. And the dock stands on the floor: what it seems to be tilted or lifted by, the mount is wrong by.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction, Kind

Array = NDArray[np.float64]

_FEWEST = 20  # images that decide
_CERTAIN = 4.0  # standard deviations of their mean
_COMMON = 2.0  # told standard deviations of one image: blur, light and print err alike in all that follow each other
_FARTHEST = 1.5  # [m] of the camera: farther away, the places of single markers and the height say little


class Mean:
    """Of values whose spread is not known before."""

    def __init__(self, size: int) -> None:
        self.count, self.value, self._square = 0, np.zeros(size), np.zeros(size)

    def add(self, value: Array) -> None:
        """One more."""
        self.count += 1
        step = value - self.value
        self.value = self.value + step / self.count
        self._square += step * (value - self.value)

    @property
    def sure(self) -> Array:
        """How far from zero each surely is; zero where it may be zero."""
        if self.count < _FEWEST:
            return np.zeros_like(self.value)
        sd = np.sqrt(self._square / (self.count - 1) / self.count)
        return np.sign(self.value) * np.maximum(0.0, np.abs(self.value) - _CERTAIN * sd)


class Markers:
    """Of one goal: `add` what images show, and `check`."""

    def __init__(self, mount: CameraMount, dock: Dock, parameters: PlausibilityParameters) -> None:
        self._T_base_optical, self._parameters = mount.T_base_optical(), parameters
        self._places = {marker.id: np.asarray(marker.position, dtype=float) for marker in dock.markers}
        self._middle = np.array([*np.mean(list(self._places.values()), axis=0), 1.0])
        self.restart()

    def restart(self) -> None:
        """Forget what was shown."""
        self._scale, self._tilt, self._height = Mean(1), Mean(2), Mean(1)
        self._tilt_sd = Mean(1)  # [rad] of one image, as perception tells
        self._off = {number: Mean(3) for number in self._places}

    def add(self, hypotheses: Sequence[Hypothesis], sights: Sequence[MarkerSight]) -> None:
        """The poses of the dock that an image leaves open, and its markers; what is not finite is left out."""
        seen = {s.number: s.T_optical_marker[:3, 3] for s in sights if s.number in self._places and s.finite}
        certain = len(hypotheses) == 1 and bool(np.all(np.isfinite(hypotheses[0].T_optical_dock)))
        if len(seen) > 1:
            self._scale.add(np.array([self._scale_of(seen) - 1.0]))
        if not certain:
            return
        T_optical_dock = hypotheses[0].T_optical_dock
        self._add_tilt(self._T_base_optical @ T_optical_dock, float((T_optical_dock @ self._middle)[2]))
        self._tilt_sd.add(np.array([self._sd_of_tilt(hypotheses[0].covariance)]))
        if len(seen) > 2 and max(float(place[2]) for place in seen.values()) <= _FARTHEST:
            self._add_places(seen, T_optical_dock)

    def check(self) -> Contradiction | None:
        """What contradicts chair.yaml or the dock's file, if that is certain."""
        p, scale = self._parameters, float(self._scale.sure[0])
        if abs(scale) > p.marker_scale:
            found = 1.0 + float(self._scale.value[0])
            return _inconsistent(
                f"the markers are {found:.3f} times as far from each other as their sizes say",
                "another print size than in the dock's file, or markers moved?",
            )
        for number, off in self._off.items():
            if float(np.abs(off.sure).max()) > p.marker_place:
                way = 1e3 * float(np.linalg.norm(off.value))
                return _inconsistent(
                    f"marker {number} is off the line of the others by {way:.0f} mm", "lifted off, or moved?"
                )
        tilt = float(np.abs(self._tilt.sure).max()) - _COMMON * float(self._tilt_sd.value[0])
        if tilt > p.mount_tilt:
            roll, pitch = np.degrees([-self._tilt.value[1], self._tilt.value[0]])
            return _inconsistent(
                f"the dock seems to be tilted by {abs(roll):.1f} deg sideways and {abs(pitch):.1f} deg forward",
                "the camera's mount in chair.yaml, a marker that hangs askew, a wheel in a hole, or a lopsided load?",
            )
        height = float(self._height.sure[0])
        if abs(height) > p.mount_height:
            return _inconsistent(
                f"the markers seem to be {1e3 * float(self._height.value[0]):+.0f} mm too high",
                "the camera's mount in chair.yaml, or the height of the markers in the dock's file?",
            )
        return None

    def _scale_of(self, seen: dict[int, Array]) -> float:
        pairs = list(itertools.combinations(seen, 2))
        measured = sum(math.dist(seen[a], seen[b]) for a, b in pairs)
        return measured / sum(math.dist(self._places[a], self._places[b]) for a, b in pairs)

    def _add_tilt(self, T_base_dock: Array, distance: float) -> None:
        """Tilt of the dock's upright axis (along x and y of base_link), and the height less what the tilt explains."""
        tilt = T_base_dock[:2, 2]
        self._tilt.add(tilt)
        if distance <= _FARTHEST:
            middle = T_base_dock @ self._middle
            arm = middle[:2] - self._T_base_optical[:2, 3]  # a mount that is tilted by so much lifts what it sees
            self._height.add(np.array([middle[2] - self._middle[2] + float(tilt @ arm)]))

    def _sd_of_tilt(self, covariance: Array) -> float:
        """[rad] of the larger one of roll and pitch."""
        R = self._T_base_optical[:2, :3]
        return math.sqrt(max(0.0, float(np.linalg.eigvalsh(R @ covariance[3:, 3:] @ R.T)[-1])))

    def _add_places(self, seen: dict[int, Array], T_optical_dock: Array) -> None:
        """Where each marker is in the dock's frame, less the shift, turns and scale that fit all of them best."""
        numbers = list(seen)
        true = np.array([self._places[number] for number in numbers])
        there = (np.array([seen[number] for number in numbers]) - T_optical_dock[:3, 3]) @ T_optical_dock[:3, :3]
        centred = true - true.mean(axis=0)
        basis = np.column_stack([np.ones(len(numbers)), centred])
        rest = (there - true) - basis @ np.linalg.lstsq(basis, there - true, rcond=1e-6)[0]
        for number, off in zip(numbers, rest, strict=True):
            self._off[number].add(off)


def _inconsistent(what: str, cause: str) -> Contradiction:
    return Contradiction(Kind.INCONSISTENT, f"{what} ({cause})")
