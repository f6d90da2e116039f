"""What the adjustment says, value by value, and what this drive could not say."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.geometry import Dock
from seater_common.se2 import wrap_angle
from seater_tools.mount.layout import FIRST_LENS, MARKER, MOUNT, ODOMETRY
from seater_tools.mount.prior import Lengths
from seater_tools.mount.solve import Solution

Array = NDArray[np.float64]
Numbers = Sequence[float] | Array

# [m], [rad] standard deviations above which a drive does not constrain the mount: five times what docking asks for.
MOUNT_LIMITS = {"x": 0.010, "y": 0.010, "z": 0.010, "roll": 0.005, "pitch": 0.005, "yaw": 0.005}
MARKER_LIMITS = {"x": 0.005, "y": 0.005, "z": 0.005, "yaw": 0.020}  # above: the marker keeps the file's place
PRINTED = ("x", "y", "z", "yaw", "size")  # what a dock file says of a marker
UNITS = {"x": "m", "y": "m", "z": "m", "size": "m", "fx": "px", "fy": "px", "cx": "px", "cy": "px"}
LENS_OFF = 4.0  # standard deviations of chi-square by which a drive contradicts the calibration of the lens
LEAN = math.radians(1.0)  # of a print: perception takes it for upright
# Movement that constrains what is not constrained.
MOVEMENTS = (
    (("x", "y"), "turn on the spot, 25 deg to the left and to the right, with markers in view"),
    (("yaw",), "drive straight, at least 1 m towards the dock and back again, with markers in view"),
    (("z", "roll", "pitch"), "drive nearer and farther with several markers in view"),
)


@dataclass(frozen=True)
class Value:
    """One unknown. `kept`: why the file's value stays; empty: the new one is used."""

    name: str
    unit: str
    file: float
    value: float
    sd: float
    kept: str = ""

    @property
    def used(self) -> float:
        """What goes into the new file."""
        return self.file if self.kept else self.value


@dataclass(frozen=True)
class Calibration:
    """`missing`: movements without which the mount is not constrained; then nothing may be written. `lens`: of the
    camera, fx, fy, cx, cy, where its calibration says how certain they are; else empty."""

    mount: list[Value]
    markers: dict[int, list[Value]]
    odometry: list[Value]
    lens: list[Value]
    scale_sd: float  # of all lengths together
    images: int
    corner_rms: float  # [px] of what is left over
    missing: list[str]
    notes: list[str]


def judge(solution: Solution, dock: Dock, lengths: Lengths) -> Calibration:
    """`dock`: as in the file."""
    layout, state, sd = solution.problem.layout, solution.state, np.sqrt(np.diag(solution.covariance))
    mount = _values(MOUNT, layout.mount(solution.start), layout.mount(state), layout.mount(sd))
    errors = layout.odometry(state)
    odometry = _values(ODOMETRY, np.zeros(len(errors)), errors, layout.odometry(sd))
    rows = dict(zip(layout.ids, zip(layout.markers(state), layout.markers(sd), strict=True), strict=True))
    markers = {m.id: _marker(m.id, dock, rows.get(m.id)) for m in dock.markers}
    off = solution.problem.drive.corners - solution.problem.corners(state)
    scale_sd = _scale_sd(solution)
    return Calibration(
        mount=mount,
        markers=markers,
        odometry=odometry,
        lens=_lens(solution),
        scale_sd=scale_sd,
        images=layout.images,
        corner_rms=float(np.sqrt(np.mean(np.median(np.sum(off**2, axis=2), axis=1)) / 2.0)),
        missing=_missing(mount, len(layout.ids)),
        notes=[*_held(), *_scale(lengths, scale_sd), *_contradicts(solution), *_leaning(rows), *_kept(markers)],
    )


def camera_of(solution: Solution) -> CameraModel:
    """The lens as the drive has it, with its covariance; the calibration itself where that says none."""
    layout, lens = solution.problem.layout, solution.problem.lens
    mine = slice(FIRST_LENS, layout.first_marker)
    return lens.found(layout.lens_off(solution.state), solution.covariance[mine, mine]) if lens.count else lens.camera


def _lens(solution: Solution) -> list[Value]:
    before, after = solution.problem.lens.camera, camera_of(solution)
    if after.covariance is None:
        return []
    names = ("fx", "fy", "cx", "cy")
    sds = np.sqrt(np.diag(after.covariance))
    return _values(names, before.parameters[:4], after.parameters[:4], sds[:4])


def _contradicts(solution: Solution) -> list[str]:
    off = solution.problem.layout.lens_off(solution.state)
    if len(off) == 0 or float(off @ off) < len(off) + LENS_OFF * math.sqrt(2.0 * len(off)):
        return []
    return [
        "The drive does not go with the lens' calibration: was the camera refocused, or is this another camera or "
        "resolution? ./seater calibrate camera."
    ]


def _marker(id: int, dock: Dock, found: tuple[Array, Array] | None) -> list[Value]:
    marker = next(marker for marker in dock.markers if marker.id == id)
    file = [*marker.position, marker.normal_yaw, marker.size]
    numbers, sds, kept = file, [math.inf] * len(file), "was not seen"
    if found is not None:
        state, sd = found
        size = marker.size * math.exp(state[MARKER.index("log_size")])
        numbers = [*map(float, state[:3]), wrap_angle(float(state[3])), size]
        sds = [*map(float, sd[:4]), size * float(sd[MARKER.index("log_size")])]
        loose = [name for name, value in zip(PRINTED, sds, strict=True) if value > MARKER_LIMITS.get(name, math.inf)]
        kept = f"not constrained ({', '.join(loose)}): come nearer, see it from other places" if loose else ""
    return _values(PRINTED, file, numbers, sds, kept)


def _values(names: Sequence[str], file: Numbers, values: Numbers, sds: Numbers, kept: str = "") -> list[Value]:
    rows = zip(names, file, values, sds, strict=True)
    return [Value(name, UNITS.get(name, "rad"), float(a), float(b), float(c), kept) for name, a, b, c in rows]


def _scale_sd(solution: Solution) -> float:
    """Of the mean of the logarithms of all sizes."""
    layout = solution.problem.layout
    weights = np.zeros(layout.first_pose)
    layout.markers(weights)[:, MARKER.index("log_size")] = 1.0 / len(layout.ids)
    return float(np.sqrt(weights @ solution.covariance @ weights))


def _missing(mount: list[Value], markers: int) -> list[str]:
    loose = {value.name for value in mount if value.sd > MOUNT_LIMITS[value.name]}
    found = [movement for names, movement in MOVEMENTS if loose.intersection(names)]
    return [*found, "hang at least two markers"] if found and markers == 1 else found


def _held() -> list[str]:
    return [
        "Not observable, kept as in the files: where the docked chair stands among the markers (teach it), and how "
        "high camera and markers are together (the markers' mean height is the file's)."
    ]


def _scale(lengths: Lengths, sd: float) -> list[str]:
    if lengths.known:
        return [f"All lengths follow from what was measured by hand, to {100 * sd:.2f} %."]
    return [
        f"No length was measured by hand: sizes of the prints and odometry are taken for right within 2 and 3 %, all "
        f"lengths are uncertain by {100 * sd:.1f} %. Measure a distance (--measured-distance) or a side."
    ]


def _leaning(rows: dict[int, tuple[Array, Array]]) -> list[str]:
    found = []
    for id, (state, sd) in rows.items():
        for name in ("tilt", "roll"):
            angle, uncertain = state[MARKER.index(name)], sd[MARKER.index(name)]
            if abs(angle) > max(LEAN, 3.0 * uncertain):
                how = "leans" if name == "tilt" else "is turned in its plane"
                found.append(
                    f"Marker {id} {how} by {abs(math.degrees(angle)):.1f} deg: hang it upright, and drive again."
                )
    return found


def _kept(markers: dict[int, list[Value]]) -> list[str]:
    return [
        f"Marker {id} keeps the file's place and size: {row[0].kept}." for id, row in markers.items() if row[0].kept
    ]
