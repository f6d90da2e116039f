"""Which stage is to blame. A stage that only waits for one before it is in order: the first that is not, is it."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from seater_nmpc.health.word import Level, Word
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.sequence.goal.results import Phase, Result, ResultCode

SILENT = 1.0  # [s] of the odometry, which comes 20 times a second or more often
UNSEEN = 1.0  # [s] a goal goes on this long without an image that is used, in daily dockings, too
FEW_CYCLES = 0.8  # of those wanted, below which it is said
MOST_OF_CYCLE = 0.6  # part of a cycle that solving may take, as the median
FAILURES = 3  # cycles in a row without a solution: then the last plan is nearly used up

SIGHT = ("camera", "detection", "pose", "observer")
# Whose fault it is that an image is not used.
_BLAMED = {
    Outcome.EMPTY: "detection",
    Outcome.FLIP: "pose",
    Outcome.UNCERTAIN: "pose",
    Outcome.INVALID: "pose",
    Outcome.FROZEN: "camera",
}


class Sight(NamedTuple):
    """What the observer has of the images."""

    goal: bool  # a goal is active
    age: float  # [s] of the newest image that was used; inf: none
    images: float  # [s] since perception answered an image; inf: never
    unused: Counter[Outcome]  # what became of the images since
    why: str  # the same in words


def base(silence: float, refused: int) -> Word:
    """`silence` [s] of the odometry, inf: none yet; messages `refused` since the last word."""
    if silence > SILENT:
        since = "no odometry yet" if math.isinf(silence) else f"no odometry for {silence:.1f} s"
        return Word(Level.ERROR, f"{since}: does the base's driver run, and is its topic the one of odom:=?")
    if refused:
        return Word(Level.WARN, f"{refused} odometry messages refused: not finite, or stamps that do not grow")
    return Word(Level.OK, "odometry comes")


def sight(stage: str, seen: Sight, odometry: Word) -> Word:
    """Of one of SIGHT. Without a goal nobody needs to see the dock."""
    if not seen.goal:
        return Word(Level.OK, "no goal: the dock need not be seen")
    if seen.age <= UNSEEN:
        return Word(Level.OK, "sees the dock")
    if odometry.level is Level.ERROR:
        return Word(Level.OK, "waits for odometry")
    if seen.images > UNSEEN:
        if stage == "detection":
            return Word(Level.ERROR, "perception answers no image: see camera; does the node marker_detector run?")
        return Word(Level.OK, "waits for detection")
    blamed = Counter[str]()
    for outcome, count in seen.unused.items():
        blamed[_BLAMED.get(outcome, "observer")] += count
    guilty = max(blamed, key=lambda name: blamed[name], default="observer")
    if stage != guilty:
        return Word(Level.OK, f"see {guilty}")
    since = "yet" if math.isinf(seen.age) else f"for {seen.age:.1f} s"
    return Word(Level.WARN, f"the dock is not seen {since}: {seen.why}")


class Solving(NamedTuple):
    """Of the last cycles."""

    failures: int  # in a row
    slowed: str  # why it drives slowly; empty: it does not
    median: float  # [s] of a solution; 0: none lately
    period: float  # [s] of a cycle
    cycles: float  # [Hz]; 0: no odometry, and no cycles


def solver(solving: Solving, odometry: Word) -> Word:
    """Solutions come, and in time."""
    if solving.failures:
        level = Level.ERROR if solving.failures >= FAILURES else Level.WARN
        text = "it follows the last plan, then brakes. Is there room for the chair, is the computer loaded?"
        return Word(level, f"{solving.failures} cycles in a row without a solution: {text}")
    if solving.slowed:
        return Word(Level.WARN, f"drives slowly: {solving.slowed}")
    if solving.median > MOST_OF_CYCLE * solving.period:
        took = f"{1e3 * solving.median:.0f} of {1e3 * solving.period:.0f} ms"
        return Word(
            Level.WARN, f"solving takes {took} of a cycle: is the computer loaded? solver: rti is the quick one"
        )
    if odometry.level is Level.ERROR:
        return Word(Level.OK, "waits for odometry")
    if solving.cycles < FEW_CYCLES / solving.period:
        text = f"{solving.cycles:.0f} cycles a second, {1.0 / solving.period:.0f} are wanted"
        return Word(Level.WARN, f"{text}: is the computer loaded, does odometry come as often?")
    return Word(Level.OK, "in time")


def sequence(phase: Phase | None, result: Result | None, held_by: str) -> Word:
    """`phase` of the active goal, None: there is none; `result` of the last one; `held_by`: who holds the chair."""
    if phase is Phase.PAUSED:
        return Word(Level.WARN, "the goal is paused: release what stopped it, then rosservice call /docking_resume")
    if phase is not None:
        return Word(Level.OK, f"{phase.name}{f', held: {held_by}' if held_by else ''}")
    if result is None:
        return Word(Level.OK, "no goal yet")
    said = f"the last goal ended with {result.code.name}: {result.text}"
    if result.success or result.code is ResultCode.CANCELED:
        return Word(Level.OK, said)
    return Word(Level.WARN, f"{said} (what to do: docs/reference/interfaces.md)")
