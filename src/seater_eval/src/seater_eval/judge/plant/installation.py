"""What is installed otherwise than the files say: print size, focal length, camera mount, a marker moved."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Marker

Array = NDArray[np.float64]

# Unit of the value, and the range of its size that is drawn where none is given; either sign.
KINDS: dict[str, tuple[str, float, float]] = {
    "size": ("share by which poses are too far away, as of prints that are smaller", 0.02, 0.20),
    "focal": ("share by which the focal length is too long", 0.02, 0.10),
    "mount_x": ("m", 0.01, 0.10),
    "mount_y": ("m", 0.01, 0.10),
    "mount_z": ("m", 0.01, 0.10),
    "mount_roll": ("deg", 0.5, 5.0),
    "mount_pitch": ("deg", 0.5, 5.0),
    "mount_yaw": ("deg", 0.5, 5.0),
    "moved_x": ("m, marker 1 lifted off the wall", 0.01, 0.10),
    "moved_y": ("m, marker 1 along the wall", 0.01, 0.10),
}
ANY = "any"


@dataclass(frozen=True)
class Installation:
    """`kind` of KINDS, or ANY: one of them, drawn; `value`: in its unit, None: drawn."""

    kind: str
    value: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in (*KINDS, ANY):
            raise ValueError(f"install: is {self.kind!r}, must be one of {', '.join(KINDS)}, {ANY}")
        if self.value is not None and not (math.isfinite(self.value) and self.kind != ANY):
            raise ValueError(f"install: value is {self.value}, must be finite, and none for {ANY}")

    def drawn(self, rng: np.random.Generator) -> Installation:
        """With everything decided."""
        kind = str(rng.choice(list(KINDS))) if self.kind == ANY else self.kind
        value = float(rng.uniform(*KINDS[kind][1:]) * rng.choice([-1.0, 1.0]))
        if kind == "moved_x":
            value = -abs(value)  # towards the chair
        return Installation(kind, value if self.value is None else self.value)

    def _of(self, kind: str) -> float:
        return self.value if self.kind == kind and self.value is not None else 0.0

    def mount(self, told: CameraMount) -> CameraMount:
        """Where the camera is."""
        return dataclasses.replace(
            told,
            **{key: getattr(told, key) + self._of(f"mount_{key}") for key in "xyz"},
            **{key: getattr(told, key) + math.radians(self._of(f"mount_{key}")) for key in ("roll", "pitch", "yaw")},
        )

    def place(self, marker: Marker) -> Array:
        """Where the centre of a marker is in the dock's frame (3,)."""
        moved = np.array([self._of("moved_x"), self._of("moved_y"), 0.0])
        return np.asarray(marker.position) + (moved if marker.id == 1 else 0.0)

    def centre(self, p: Array) -> Array:
        """Where a marker's centre at `p` (3,) of the optical frame seems to be."""
        return p * (1.0 + self._of("size") + np.array([0.0, 0.0, self._of("focal")]))

    def pose(self, T_optical_dock: Array, markers: Sequence[Marker]) -> Array:
        """The dock's pose that perception makes of these markers."""
        T = T_optical_dock @ self._fitted(markers)
        middle = np.mean([marker.position for marker in markers], axis=0)
        p = T[:3, :3] @ middle + T[:3, 3]
        x, z = -T[0, 1], -T[2, 1]  # along the wall
        turn = math.atan2((1.0 + self._of("focal")) * z, x) - math.atan2(z, x)
        c, s = math.cos(turn), math.sin(turn)
        wrong = np.eye(4)
        wrong[:3, :3] = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]]) @ T[:3, :3]
        wrong[:3, 3] = self.centre(p) - wrong[:3, :3] @ middle
        return wrong

    def _fitted(self, markers: Sequence[Marker]) -> Array:
        """Shift and turn on the floor, (4, 4), that take the told places nearest to the true ones."""
        told = np.array([marker.position[:2] for marker in markers])
        true = np.array([self.place(marker)[:2] for marker in markers])
        a, b = told - told.mean(axis=0), true - true.mean(axis=0)
        turn = math.atan2(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])), float(np.sum(a * b)) or 1.0)
        E = np.eye(4)
        E[:2, :2] = [[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]]
        E[:2, 3] = true.mean(axis=0) - E[:2, :2] @ told.mean(axis=0)
        return E


def parse(text: str) -> Installation:
    """KIND[:VALUE] or any. Raises ValueError, naming what is allowed."""
    kind, _, value = text.partition(":")
    Installation(kind)
    try:
        number = float(value) if value else None
    except ValueError as error:
        raise ValueError(f"install: is {text!r}, must be KIND[:VALUE] with a number") from error
    return Installation(kind, number)
