"""One docking as a line of the history. SI units and radians; a field that is not known is NaN, in the file empty."""

from __future__ import annotations

import csv
import dataclasses
import datetime
import io
import math
import typing
from dataclasses import dataclass
from typing import Any


class HistoryError(ValueError):
    """The history cannot be used; the message says why."""


@dataclass(frozen=True, kw_only=True)
class Docking:
    """Names and order of the fields are the columns of the file (docs/how-to/watch_the_dockings.md)."""

    time: datetime.datetime  # of the result, UTC
    dock: str
    code: int  # of Dock.action
    text: str
    duration: float  # [s]
    tries: int  # 1: at once
    reversals: int  # changes of direction of what was asked for
    contact: int  # 1: closed
    # Estimated final error and its standard deviations; NaN where nothing was verified.
    x: float = math.nan  # [m] along the dock
    y: float = math.nan  # [m]
    heading: float = math.nan  # [rad]
    position_sd: float = math.nan  # [m]
    heading_sd: float = math.nan  # [rad]
    # Innovations of the images that showed the dock.
    images: int = 0
    accepted: float = math.nan  # share of them
    nis: float = math.nan  # mean, of those that had an estimate to be compared with; 3 where all is as believed
    innovation: float = math.nan  # [m] rms of position
    # By what the images make of the way driven, the installation is off (plausibility), with standard deviations.
    mount_x: float = math.nan  # [m]
    mount_y: float = math.nan  # [m]
    mount_yaw: float = math.nan  # [rad]
    depth: float = math.nan  # share: focal length, or size of the prints
    mount_x_sd: float = math.nan
    mount_y_sd: float = math.nan
    mount_yaw_sd: float = math.nan
    depth_sd: float = math.nan
    taught: str = ""  # UTC date of the dock's teaching; empty: not taught
    teaching_age: float = math.nan  # [days]

    @property
    def success(self) -> bool:
        """Docked, or found docked."""
        return self.code in (0, 1)


COLUMNS = tuple(field.name for field in dataclasses.fields(Docking))
_TYPES = typing.get_type_hints(Docking)


def header() -> str:
    """The first line of the file."""
    return ",".join(COLUMNS) + "\n"


def as_line(docking: Docking) -> str:
    """CSV, one line whatever the text holds."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerow(_written(getattr(docking, name)) for name in COLUMNS)
    return stream.getvalue()


def of_row(row: list[str]) -> Docking:
    """Raises HistoryError: not a line of this format."""
    if len(row) != len(COLUMNS):
        raise HistoryError(f"{len(row)} fields, must be {len(COLUMNS)}")
    try:
        return Docking(**{name: _read(name, text) for name, text in zip(COLUMNS, row, strict=True)})
    except ValueError as error:
        raise HistoryError(str(error)) from error


def _written(value: object) -> str:
    if isinstance(value, datetime.datetime):
        return value.astimezone(datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return " ".join(str(value).split())


def _read(name: str, text: str) -> Any:
    kind = _TYPES[name]
    if kind is datetime.datetime:
        return datetime.datetime.fromisoformat(text.replace("Z", "+00:00"))
    if kind is float:
        return float(text) if text else math.nan
    return int(text) if kind is int else text
