"""An installation as it is: hung, printed and mounted a little wrong."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import CameraMount, Dock, Marker
from seater_common.se2 import wrap_angle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """Largest error of each kind; drawn uniformly."""

    place: float = 0.02  # [m] of a marker, along each axis
    turn: float = math.radians(3.0)  # [rad] of its normal
    lean: float = 0.0  # [rad] tilt and roll
    size: float = 0.02  # of a print, each by itself
    mount: float = 0.03  # [m] of the camera, along each axis
    mount_turn: float = math.radians(3.0)  # [rad] about each axis


@dataclass(frozen=True)
class Installation:
    """`leans`: (markers, 2) tilt and roll [rad], which a dock file does not know."""

    mount: CameraMount
    dock: Dock
    leans: Array


def draw_installation(mount: CameraMount, dock: Dock, errors: Errors, rng: np.random.Generator) -> Installation:
    """What is really there, where the files say `mount` and `dock`."""

    def off(size: float, count: int = 1) -> list[float]:
        return (size * rng.uniform(-1.0, 1.0, count)).tolist()

    markers = [_drawn(marker, off(errors.place, 3), *off(errors.turn), *off(errors.size)) for marker in dock.markers]
    moved = dict(zip(("x", "y", "z"), off(errors.mount, 3), strict=True))
    turned = dict(zip(("roll", "pitch", "yaw"), off(errors.mount_turn, 3), strict=True))
    values = {name: getattr(mount, name) + change for name, change in (moved | turned).items()}
    leans = np.array(off(errors.lean, 2 * len(markers))).reshape(-1, 2)
    return Installation(CameraMount(**values), dataclasses.replace(dock, markers=markers), leans)


def _drawn(marker: Marker, shift: list[float], turn: float, scale: float) -> Marker:
    position = [value + change for value, change in zip(marker.position, shift, strict=True)]
    return Marker(marker.id, marker.size * (1.0 + scale), position, wrap_angle(marker.normal_yaw + turn))


def describe_truth(truth: Installation) -> str:
    """In millimetres and degrees, and what a tape would read between the markers that are farthest apart."""
    m, markers = truth.mount, truth.dock.markers
    lines = [
        f"simulated: camera {1000 * m.x:.1f} {1000 * m.y:.1f} {1000 * m.z:.1f} mm, "
        + " ".join(f"{math.degrees(angle):.3f}" for angle in (m.roll, m.pitch, m.yaw))
        + " deg"
    ]
    for marker in markers:
        place = " ".join(f"{1000 * value:.1f}" for value in marker.position)
        lines.append(
            f"  marker {marker.id}: {place} mm, {math.degrees(marker.normal_yaw):.3f} deg, {1000 * marker.size:.2f} mm"
        )
    pairs = [(math.dist(a.position, b.position), a.id, b.id) for a in markers for b in markers if a.id < b.id]
    if pairs:
        distance, a, b = max(pairs)
        lines.append(f"  a tape would read --measured-distance {a} {b} {1000 * distance:.1f}")
    return "\n".join(lines)
