"""What a person does, in order, and how long it takes them: estimates, of what no simulation shows."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Step:
    """`minutes`: of a person, without the simulated driving. `why`: what they do."""

    name: str
    minutes: float
    why: str


STEPS = (
    Step("sheets", 15.0, "print, measure the bars, glue three markers on plates, hang them by level and plumb line"),
    Step("lens", 9.0, "print and glue the board (4), hold it in 20 places (5)"),
    Step("mount", 5.0, "measure one distance by a tape (1), start camera, base and recording (3), compute (1)"),
    Step("identify", 4.0, "clear the area, put the chair into it, read the result"),
    Step("teach", 3.0, "drive in by hand, let it stand, confirm"),
    Step("doctor", 3.0, "start everything with the new files, read what it says"),
    Step("dockings", 3.0, "watch, and look where the chair stands"),
)
LIMIT = 60.0  # [min] of all, driving included


def people_minutes() -> float:
    """Of all steps."""
    return sum(step.minutes for step in STEPS)
