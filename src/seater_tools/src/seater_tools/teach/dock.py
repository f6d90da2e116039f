"""The dock file whose frame lies where the chair stood; and what it says of its teaching."""

from __future__ import annotations

import datetime
import math
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.files.installation import TAUGHT
from seater_common.files.scalars import Path, with_values
from seater_common.geometry import Dock
from seater_common.se2 import compose, inverse, transform_points, wrap_angle
from seater_tools.correct.sizes import CORRECTED
from seater_tools.correct.wall import wall_values
from seater_tools.teach.measure import Measurement, TeachError

Array = NDArray[np.float64]

FARTHEST, MOST_TURNED = 0.3, math.radians(15.0)  # from where the file has the docked chair: else it is another dock
BESIDE = 0.005  # [m] of the bay's middle from the taught place, which is worth a word
_LINE = re.compile(
    rf"^{TAUGHT}(?P<date>\S+Z), (?P<count>\d+) measurements in (?P<duration>[\d.]+) s, spread (?P<x>[\d.]+) mm "
    r"(?P<y>[\d.]+) mm (?P<heading>[\d.]+) deg$",
    re.MULTILINE,
)


@dataclass(frozen=True)
class Teaching:
    """What a dock file says of how it was taught: `spread` in x, y [m], heading [rad] of one measurement."""

    date: datetime.datetime
    count: int
    duration: float
    spread: tuple[float, float, float]


def taught_text(text: str, name: str, dock: Dock, measured: Measurement, now: datetime.datetime) -> str:
    """The dock file's text with its frame where the measured chair stands docked; comments and all else stay.

    Every marker keeps its place in the world, and so does the back wall, unless a print would hang behind it.

    Raises:
        TeachError: the chair stands too far from where the file has the docked one.
        ParameterError: naming a key that cannot be replaced.
    """
    moved = motion(dock, measured.pose)
    if math.hypot(moved[0], moved[1]) > FARTHEST or abs(moved[2]) > MOST_TURNED:
        raise TeachError(
            f"the chair stands {1000 * math.hypot(moved[0], moved[1]):.0f} mm and {math.degrees(moved[2]):.1f} deg "
            f"from the docked pose of {name} (at most {1000 * FARTHEST:.0f} mm, {math.degrees(MOST_TURNED):.0f} deg): "
            "is it this dock?"
        )
    values: dict[Path, float] = {}
    places = []
    for i, marker in enumerate(dock.markers):
        x, y = transform_points(inverse(moved), np.array([marker.position[:2]]))[0]
        values["markers", i, "position", 0], values["markers", i, "position", 1] = float(x), float(y)
        places.append(float(x))
        values["markers", i, "normal_yaw"] = wrap_angle(marker.normal_yaw - moved[2])
    values |= wall_values(dock.bay, (dock.bay.back_wall_x - moved[0]) / math.cos(moved[2]), places)
    return _with_line(with_values(text, values, name), _line(measured, now))


def motion(dock: Dock, T_dock_base: Array) -> Array:
    """(3,) pose of the new dock frame in the old one, for a docked chair that stands at T_dock_base."""
    return compose(T_dock_base, inverse(dock.docked_pose))


def remarks(dock: Dock, measured: Measurement) -> list[str]:
    """What the file cannot hold."""
    beside = float(motion(dock, measured.pose)[1])
    if abs(beside) <= BESIDE:
        return []
    side = "left" if beside > 0 else "right"
    return [
        f"The taught place is {1000 * abs(beside):.0f} mm {side} of the bay's middle: a dock file has the side walls "
        "on both sides alike, so they are off by that."
    ]


def teaching_of(text: str) -> Teaching | None:
    """Of a dock file's text; None: it was not taught."""
    match = _LINE.search(text)
    if match is None:
        return None
    date = datetime.datetime.fromisoformat(match["date"].replace("Z", "+00:00"))
    spread = (0.001 * float(match["x"]), 0.001 * float(match["y"]), math.radians(float(match["heading"])))
    return Teaching(date, int(match["count"]), float(match["duration"]), spread)


def without_teaching(text: str) -> str:
    """The dock file's text without the line that says when it was taught."""
    return "".join(line for line in text.splitlines(keepends=True) if not line.startswith(TAUGHT))


def _line(measured: Measurement, now: datetime.datetime) -> str:
    date = now.astimezone(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    x, y, heading = 1000 * measured.spread[0], 1000 * measured.spread[1], math.degrees(measured.spread[2])
    return (
        f"{TAUGHT}{date}, {measured.count} measurements in {measured.duration:.1f} s, "
        f"spread {x:.2f} mm {y:.2f} mm {heading:.3f} deg"
    )


def _with_line(text: str, line: str) -> str:
    """In the place of an earlier teaching's; behind the line about sizes, which has to be the first."""
    if _LINE.search(text):
        return _LINE.sub(line, text, count=1)
    head, newline, rest = text.partition("\n")
    return f"{head}{newline}{line}\n{rest}" if head.startswith(CORRECTED) else f"{line}\n{text}"
