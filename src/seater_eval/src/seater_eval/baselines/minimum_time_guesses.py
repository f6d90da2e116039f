"""Motions from which the search for the minimum time begins."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_common.se2 import arc_step, compose, relative
from seater_eval.baselines.closed_loop import run_perfect
from seater_eval.baselines.park_kuipers import ParkKuipers
from seater_eval.baselines.pbvs import Pbvs

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Guess:
    """A motion in pieces, one for each phase, and the whole turns of the target's heading."""

    name: str
    pieces: tuple[Array, ...]  # (n, 5) each: x, y, heading (unwrapped), v, omega, evenly in time
    durations: tuple[float, ...]  # [s]
    turns: int

    def states(self, phase: int, steps: int) -> Array:
        """The phase on `steps` equal steps, (steps + 1, 5)."""
        piece = self.pieces[phase]
        at = np.linspace(0.0, len(piece) - 1.0, steps + 1)
        return np.column_stack([np.interp(at, np.arange(len(piece)), column) for column in piece.T])


def guesses(chair: Chair, dock: Dock | None, start: Array) -> list[Guess]:
    """The more promising ones first."""
    result = []
    for via in _vias(dock, start):
        name, states, period = _through(chair, start, via)
        result.append(_cut(chair, dock, name, states, period))
    for turns in _turns(start):
        result.append(_line(chair, dock, start, turns))
    return result


def _turns(start: Array) -> list[int]:
    """Whole turns of the target to try: the nearest, and the second one when it is not much farther."""
    order = sorted((-1, 0, 1), key=lambda turns: abs(float(start[2]) - 2.0 * math.pi * turns))
    return order[:2] if abs(float(start[2])) > 0.5 * math.pi else order[:1]


def _vias(dock: Dock | None, start: Array) -> list[tuple[str, list[Array]]]:
    """Points to drive through on the way to the dock: ahead of it, and behind the chair to gain space for turning."""
    ahead = (-1.2, -1.8) if dock is None else (dock.predock_x, 1.5 * dock.predock_x)
    routes: list[tuple[str, list[Array]]] = [("pbvs", []), ("park_kuipers", [])]
    routes += [(f"pbvs through {x:.1f} m", [np.array([x, 0.0, 0.0])]) for x in ahead]
    for way in (0.3, 0.7):
        for turn in (-0.6, 0.0, 0.6):
            middle = arc_step(start, -way, -turn, 1.0)
            routes.append((f"back {way:.1f} m turning {turn:+.1f} rad, pbvs", [middle]))
    return routes


def _through(chair: Chair, start: Array, route: tuple[str, list[Array]]) -> tuple[str, Array, float]:
    """States (n, 5) of a drive by feedback through the points of the route, with the control period."""
    name, points = route
    law = ParkKuipers(chair.limits) if name == "park_kuipers" else Pbvs(chair.limits)
    parts = []
    for goal in [*points, np.zeros(3)]:
        drive = run_perfect(law, chair.limits, relative(goal, start), 40.0, until=_arrived)
        poses = np.array([compose(goal, pose) for pose in drive.poses])
        parts.append(np.column_stack([poses, drive.speeds]))
        start = poses[-1]
    states = np.concatenate(parts)
    states[:, 2] = np.unwrap(states[:, 2])
    return name, states, law.period


def _arrived(pose: Array, speed: tuple[float, float]) -> bool:
    return math.hypot(pose[0], pose[1]) < 0.02


def _line(chair: Chair, dock: Dock | None, start: Array, turns: int) -> Guess:
    """Pose along a straight line, at a modest speed."""
    end = np.array([0.0, 0.0, 2.0 * math.pi * turns])
    fraction = np.linspace(0.0, 1.0, 60)[:, None]
    poses = start + fraction * (end - start)
    duration = 2.0 + 2.0 * math.hypot(start[0], start[1]) / chair.limits.v_max
    states = np.column_stack([poses, np.full(60, 0.3 * chair.limits.v_max), np.zeros(60)])
    return _cut(chair, dock, "straight line", states, duration / 59.0)


def _cut(chair: Chair, dock: Dock | None, name: str, states: Array, period: float) -> Guess:
    """The motion cut where the chair enters the bay for the last time."""
    turns = round(float(states[-1, 2]) / (2.0 * math.pi))
    if dock is None:
        return Guess(name, (states,), (max(0.5, period * (len(states) - 1)),), turns)
    outside = np.flatnonzero([np.max(chair.corners_at(z[:3])[:, 0]) <= dock.bay.entrance_x for z in states])
    at = int(np.clip(outside[-1] if len(outside) else 1, 1, len(states) - 2))
    pieces = (states[: at + 1], states[at:])
    slow = 0.75 / chair.limits.v_bay_max
    return Guess(name, pieces, (max(0.5, period * at), max(slow, period * (len(states) - 1 - at))), turns)
