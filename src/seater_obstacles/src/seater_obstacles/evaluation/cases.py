"""What stands or walks where in a run."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, polygon_distance
from seater_sim.settings import Obstacle, RangingSettings, SimulatorSettings, Walker

Array = NDArray[np.float64]

CASES = ("clean", "box", "post", "person")
_FIRST_GAP = 0.5  # [m] between the chair at the start and what stands
_SPEED = 1.2  # [m/s] of the person
_ASIDE = 3.0  # [m] beside the way, where he starts
_DRIVES = 0.45  # [m/s] mean speed of a chair on its way, by which he is timed
_EARLY_OR_LATE = 2.0  # [s] that he comes before or after the chair


@dataclass(frozen=True)
class Scene:
    """A start (x, y, heading) in the dock's frame, and the simulator's settings with what is in the way."""

    start: Array
    settings: SimulatorSettings


def draw_scene(case: str, sensor: str, base: SimulatorSettings, chair: Chair, rng: np.random.Generator) -> Scene:
    """`case`: one of CASES; `sensor`: scan or depth."""
    far = case in ("box", "post")  # room for the way round
    x = rng.uniform(-4.2, -3.6) if far else rng.uniform(-3.4, -2.4)
    y = rng.uniform(-0.5, 0.5)
    start = np.array([x, y, math.atan2(-y, -1.0 - x) + rng.uniform(-0.2, 0.2)])
    things = [] if not far else _standing(case, start, chair, rng)
    walkers = [_crossing(start, rng)] if case == "person" else []
    settings = dataclasses.replace(
        base, ranging=dataclasses.replace(base.ranging, kind=sensor), obstacles=things, walkers=walkers
    )
    assert isinstance(settings.ranging, RangingSettings)
    return Scene(start, settings)


def _standing(case: str, start: Array, chair: Chair, rng: np.random.Generator) -> list[Obstacle]:
    """A box, or two posts, near the straight way to the bay; the chair at the start is clear of them."""
    things: list[Obstacle] = []
    while len(things) < (1 if case == "box" else 2):
        x, aside = rng.uniform(-2.6, -1.9), rng.uniform(-0.35, 0.35)
        middle = np.array([x, start[1] * x / start[0] + aside])
        if case == "box":
            half, turn = rng.uniform(0.12, 0.25, 2), rng.uniform(-math.pi, math.pi)
            corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
            c, s = math.cos(turn), math.sin(turn)
            outline, height = middle + corners @ np.array([[c, s], [-s, c]]), rng.uniform(0.3, 1.0)
        else:
            angles = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
            outline = middle + rng.uniform(0.03, 0.08) * np.column_stack([np.cos(angles), np.sin(angles)])
            height = 1.0
        if polygon_distance(chair.corners_at(start), outline) > _FIRST_GAP:
            things.append(Obstacle(outline.reshape(-1).tolist(), height))
    return things


def _crossing(start: Array, rng: np.random.Generator) -> Walker:
    """Walks across the way into the bay, when the chair's front is about there."""
    x = rng.uniform(start[0] + 1.2, -0.4)
    side = rng.choice([-1.0, 1.0])
    slant = rng.uniform(-0.4, 0.4)
    direction = np.array([math.sin(slant), -side * math.cos(slant)])
    begin = np.array([x, 0.0]) - _ASIDE * direction
    meets = (x - start[0] - 0.75) / _DRIVES + 1.0 + rng.uniform(-_EARLY_OR_LATE, _EARLY_OR_LATE)
    return Walker(
        start=begin.tolist(),
        velocity=(_SPEED * direction).tolist(),
        begin=max(0.0, meets - _ASIDE / _SPEED),
        duration=2.0 * _ASIDE / _SPEED,
    )
