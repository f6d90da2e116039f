"""All that a page shows, as one mapping that JSON can carry."""

from __future__ import annotations

import math
from typing import Any

from seater_common.geometry import Chair, Dock
from seater_common.se2 import relative
from seater_panel.view.heard import Heard, Result
from seater_panel.view.scene import scene
from seater_panel.view.words import GATE_PATIENCE, headline, running

ODOMETRY_PATIENCE = 0.5  # [s]
IMAGE_PATIENCE = 2.0  # [s]


def view(heard: Heard, chair: Chair, dock: Dock, now: float) -> dict[str, Any]:
    """`now` [s] by the clock of `heard`; `dock`: until the docking node says which one is in use. A value that is not
    known, not finite or too old is None."""
    dock = heard.in_use or dock
    progress = running(heard.progress, heard.result, now)
    title, reason = headline(heard.gate, progress, heard.result, now)
    gate, motion = heard.gate, heard.motion
    fresh = motion is not None and now - motion.time <= ODOMETRY_PATIENCE
    distance = None
    if fresh and motion is not None and heard.dock is not None:
        distance = math.hypot(*dock.docking_error(relative(heard.dock, motion.pose))[:2])
    return {
        "dock": dock.name,
        "docks": list(heard.docks),
        "title": title,
        "reason": reason,
        "active": None if progress is None else progress.action,
        "distance": _number(distance),
        "elapsed": _number(None if progress is None else progress.elapsed),
        "speed": _number(motion.v if fresh and motion is not None else None),
        "gate": None if gate is None or now - gate.time > GATE_PATIENCE else gate.state,
        "image": heard.image is not None and now - heard.image <= IMAGE_PATIENCE,
        "result": None if heard.result is None else _result(heard.result, now),
        "scene": scene(heard, chair, dock, now),
    }


def _result(result: Result, now: float) -> dict[str, Any]:
    error = None
    if result.error is not None:
        x, y, heading = result.error
        error = {"distance": _number(1e3 * math.hypot(x, y)), "heading": _number(math.degrees(heading))}  # [mm], [deg]
    return {
        "action": result.action,
        "code": result.code,
        "name": result.name,
        "text": result.text,
        "success": result.success,
        "error": error,
        "age": round(now - result.time, 1),
    }


def _number(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(value, 4)
