"""From what a docking says while it goes on to its line. One docking at a time; ROS-free."""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from seater_tools.history.docking import Docking
from seater_tools.teach.dock import teaching_of

MOVES = 0.01  # [m/s] asked for, from which on there is a direction
UNSEEN = (9,)  # outcomes of DockInnovation that are of no dock


@dataclass(frozen=True)
class Result:
    """As Dock.action; heading [rad], sd 0: not verified."""

    code: int
    text: str
    duration: float
    retries: int
    contact: bool
    error: tuple[float, float, float]
    position_sd: float
    heading_sd: float


class Collector:
    """`begin` with each goal, then what comes; `finish` makes the line."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Forget the docking before."""
        self._direction, self._reversals = 0, 0
        self._accepted: list[bool] = []
        self._nis: list[float] = []
        self._off: list[float] = []
        self._contact = False

    def asked(self, v: float) -> None:
        """A velocity request [m/s]."""
        direction = (v > MOVES) - (v < -MOVES)
        if direction:
            self._reversals += direction == -self._direction
            self._direction = direction

    def innovation(self, outcome: int, accepted: bool, x: float, y: float, nis: float) -> None:
        """Of one image that shows the dock; NaN: there was no estimate to compare with."""
        if outcome in UNSEEN:
            return
        self._accepted.append(accepted)
        if math.isfinite(nis) and math.isfinite(x) and math.isfinite(y):
            self._nis.append(nis)
            self._off.append(math.hypot(x, y))

    def contact(self, closed: bool) -> None:
        """It closed on the way."""
        self._contact = self._contact or closed

    def finish(
        self,
        result: Result,
        dock: str,
        dock_text: str,
        now: datetime.datetime,
        installation: Mapping[str, tuple[float, float]],
    ) -> Docking:
        """`dock_text`: of the dock's file, for its teaching. installation: value and sd of mount_x, mount_y, mount_yaw,
        depth, as far as they are known."""
        taught = teaching_of(dock_text)
        verified = result.position_sd > 0.0
        x, y, heading = result.error if verified else (math.nan,) * 3
        values = {name: value for name, (value, _) in installation.items()}
        values |= {f"{name}_sd": sd for name, (_, sd) in installation.items()}
        return Docking(
            time=now,
            dock=dock,
            code=result.code,
            text=result.text,
            duration=result.duration,
            tries=result.retries + 1,
            reversals=self._reversals,
            contact=int(result.contact or self._contact),
            x=x,
            y=y,
            heading=heading,
            position_sd=result.position_sd if verified else math.nan,
            heading_sd=result.heading_sd if verified else math.nan,
            images=len(self._accepted),
            accepted=float(np.mean(self._accepted)) if self._accepted else math.nan,
            nis=float(np.mean(self._nis)) if self._nis else math.nan,
            innovation=float(np.sqrt(np.mean(np.square(self._off)))) if self._off else math.nan,
            taught="" if taught is None else f"{taught.date:%Y-%m-%dT%H:%M:%SZ}",
            teaching_age=math.nan if taught is None else (now - taught.date).total_seconds() / 86400.0,
            **values,
        )
