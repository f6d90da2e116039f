"""Series of a history, and what has changed in them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.history.docking import Docking
from seater_tools.history.drift import Drift, find_drift
from seater_tools.history.evidence import Evidence, added_up
from seater_tools.history.rate import Rise, find_rise

OLD = 365.0  # [days] after which a teaching is worth a word
# Codes that say nothing of the chair.
BY_PERSONS = (ResultCode.CANCELED, ResultCode.STOPPED_BY_USER, ResultCode.EMERGENCY_STOP)
TEACH = "look whether markers, contact or camera were moved; then ./seater teach, or ./seater calibrate mount"
MOUNT = "was the camera knocked, or a marker? ./seater doctor --move, then ./seater calibrate mount"
IMAGES = "clean lens and prints, look at light and tyres; ./seater doctor"
TIME = "look at what stands in the way, at tyres and battery; ./seater identify"


@dataclass(frozen=True)
class Series:
    """A column over time. `factor`: to the unit that is printed."""

    name: str
    text: str
    unit: str
    factor: float
    remedy: str

    def values(self, dockings: Sequence[Docking]) -> np.ndarray:
        """(n,) in SI units; NaN where there is none. Errors of dockings that ended docked only."""
        ended = [getattr(d, self.name) if d.success else math.nan for d in dockings]
        return np.array(ended, dtype=float)


SERIES = (
    Series("x", "final error along the dock", "mm", 1e3, TEACH),
    Series("y", "final error across", "mm", 1e3, TEACH),
    Series("heading", "final heading error", "deg", math.degrees(1.0), TEACH),
    Series("position_sd", "uncertainty of the final error", "mm", 1e3, IMAGES),
    Series("nis", "innovation against its own uncertainty (NIS)", "", 1.0, IMAGES),
    Series("innovation", "innovation", "mm", 1e3, IMAGES),
    Series("accepted", "share of images that are used", "%", 1e2, IMAGES),
    Series("mount_x", "the camera's x, as dockings see it", "mm", 1e3, MOUNT),
    Series("mount_y", "the camera's y, as dockings see it", "mm", 1e3, MOUNT),
    Series("mount_yaw", "the camera's yaw, as dockings see it", "deg", math.degrees(1.0), MOUNT),
    Series("depth", "distances, as dockings see them", "%", 1e2, MOUNT),
    Series("duration", "time taken", "s", 1.0, TIME),
    Series("reversals", "changes of direction", "", 1.0, TIME),
)
RATES: tuple[tuple[str, Callable[[Docking], bool], str], ...] = (
    ("dockings with a second try", lambda d: d.tries > 1, TEACH),
    (
        "dockings that fail",
        lambda d: not d.success and d.code not in BY_PERSONS,
        "the codes: docs/reference/interfaces.md",
    ),
)


@dataclass(frozen=True)
class Notice:
    """`at`: index of the docking with which it began or was noticed; None: it is of all."""

    text: str
    remedy: str
    at: int | None = None

    def is_of(self, series: Series) -> bool:
        """Whether it is about this one."""
        return self.text.startswith(f"{series.text}:")


def of_dock(dockings: Sequence[Docking], name: str | None) -> list[Docking]:
    """Of one dock, None: the one of the last docking; since its last teaching."""
    wanted = name if name is not None else dockings[-1].dock if dockings else ""
    own = [docking for docking in dockings if docking.dock == wanted]
    return [docking for docking in own if docking.taught == own[-1].taught] if own else []


def warnings_of(dockings: Sequence[Docking]) -> list[Notice]:
    """Of the dockings of one dock since one teaching, in their order."""
    found = []
    for series in SERIES:
        drift = find_drift(series.values(dockings))
        if drift is not None:
            found.append(_of_drift(series, drift, dockings))
    for text, is_set, remedy in RATES:
        rise = find_rise([is_set(docking) for docking in dockings])
        if rise is not None:
            found.append(_of_rise(text, rise, remedy))
    found += [_of_evidence(evidence) for evidence in added_up(dockings) if evidence.is_off]
    age = dockings[-1].teaching_age if dockings else math.nan
    if age > OLD:
        found.append(
            Notice(f"the docked pose was taught {age:.0f} days ago", "./seater teach, where floor or wall moved")
        )
    return found


def _of_drift(series: Series, drift: Drift, dockings: Sequence[Docking]) -> Notice:
    since = dockings[drift.begin].time
    before, after = series.factor * drift.before, series.factor * drift.after
    text = f"{series.text}: {before:.3g} {series.unit} before, {after:.3g} since {since:%Y-%m-%d %H:%M}"
    return Notice(" ".join(text.split()), series.remedy, drift.begin)


def _of_rise(text: str, rise: Rise, remedy: str) -> Notice:
    return Notice(
        f"{text}: {100 * rise.now:.0f} % of the last 20, {100 * rise.before:.0f} % before", remedy, rise.noticed
    )


def _of_evidence(evidence: Evidence) -> Notice:
    series = next(one for one in SERIES if one.name == evidence.name)
    value = f"{series.factor * evidence.value:+.1f} +- {series.factor * evidence.sd:.1f} {series.unit}"
    return Notice(f"{series.text}: off by {value}, {evidence.count} dockings together", MOUNT)
