"""What happens to the world during a run, at a given simulated time or distance from the dock: always the same way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from seater_common.params import ParameterError

GOOD, NAN, NAN_CAMERA_INFO, OFF = "good", "nan", "nan_camera_info", "off"
ACTIONS = {
    "cover": "the markers are hidden by a sheet of cardboard (all, or those in `ids`)",
    "uncover": "they are seen again",
    "good_images": "the camera works",
    "nan_images": "images of encoding 32FC1, full of NaN",
    "nan_camera_info": "good images, but a camera matrix full of NaN",
    "camera_off": "no images",
    "odometry_off": "no odometry messages",
    "odometry_on": "odometry messages again",
}
_MODE = {"good_images": GOOD, "nan_images": NAN, "nan_camera_info": NAN_CAMERA_INFO, "camera_off": OFF}


@dataclass(frozen=True)
class Event:
    """One thing that happens once: `at` [s] after the start, or when the dock is nearer than `distance_below` [m]."""

    do: str
    at: float = math.inf
    distance_below: float = -math.inf
    ids: tuple[int, ...] = ()

    def is_due(self, elapsed: float, distance: float) -> bool:
        """For the time since the start [s] and the distance of base_link from the docking pose [m]."""
        return elapsed >= self.at or distance < self.distance_below


@dataclass
class WorldState:
    """What the events change."""

    marker_ids: frozenset[int]
    covered: frozenset[int] = frozenset()
    images: str = GOOD
    odometry: bool = True

    def cover(self, on: bool, ids: Iterable[int] = ()) -> None:
        """Hide the markers or show them again; no ids: all of them."""
        chosen = frozenset(ids) or self.marker_ids
        self.covered = self.covered | chosen if on else self.covered - chosen

    def apply(self, event: Event) -> None:
        """Let it happen."""
        if event.do in ("cover", "uncover"):
            self.cover(event.do == "cover", event.ids)
        elif event.do in _MODE:
            self.images = _MODE[event.do]
        else:
            self.odometry = event.do == "odometry_on"


@dataclass
class Schedule:
    """The events still to come."""

    events: list[Event] = field(default_factory=list)

    def take_due(self, elapsed: float, distance: float) -> list[Event]:
        """Those that are due now, in the order of the list; each is given once."""
        due = [event for event in self.events if event.is_due(elapsed, distance)]
        self.events = [event for event in self.events if event not in due]
        return due


def load_events(values: Any, prefix: str, marker_ids: Iterable[int]) -> list[Event]:
    """Events from the list that YAML gives, e.g. [{at: 3.0, do: cover}, {distance_below: 1.2, do: cover, ids: [0]}].

    Raises:
        ParameterError: naming key, value and what is allowed.
    """
    if not isinstance(values, list | tuple):
        raise ParameterError(f"{prefix}: is {values!r}, must be a list of events")
    known = frozenset(marker_ids)
    return [_load_event(value, f"{prefix}[{i}]", known) for i, value in enumerate(values)]


def _load_event(value: Any, key: str, marker_ids: frozenset[int]) -> Event:
    if not isinstance(value, Mapping):
        raise ParameterError(f"{key}: is {value!r}, must be a mapping such as {{at: 3.0, do: cover}}")
    unknown = set(value) - {"at", "distance_below", "do", "ids"}
    if unknown:
        raise ParameterError(f"{key}/{min(map(str, unknown))}: unknown key; known are at, distance_below, do, ids")
    if value.get("do") not in ACTIONS:
        raise ParameterError(f"{key}/do: is {value.get('do')!r}, must be one of {', '.join(ACTIONS)}")
    triggers = [name for name in ("at", "distance_below") if name in value]
    if len(triggers) != 1:
        raise ParameterError(f"{key}: has {len(triggers)} of the keys at [s] and distance_below [m], must have one")
    number = value[triggers[0]]
    if isinstance(number, bool) or not isinstance(number, int | float) or not (math.isfinite(number) and number >= 0.0):
        raise ParameterError(f"{key}/{triggers[0]}: is {number!r}, must be a number >= 0")
    ids = value.get("ids", [])
    if not isinstance(ids, list | tuple) or not all(i in marker_ids for i in ids):
        raise ParameterError(f"{key}/ids: is {ids!r}, must list markers of the dock: {sorted(marker_ids)}")
    return Event(do=value["do"], ids=tuple(ids), **{triggers[0]: float(number)})
