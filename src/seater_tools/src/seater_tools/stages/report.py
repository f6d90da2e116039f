"""The tree for the terminal and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence

from seater_tools.stages.tree import Heard, Level, first_failing

MARKS = {Level.OK: "\u2714", Level.WARN: "!", Level.ERROR: "\u2718", Level.STALE: "-"}


def conclusion(heard: Sequence[Heard]) -> str:
    """One sentence: which stage, why, and what to do."""
    failing = first_failing(heard)
    if failing is None:
        return "no stage fails"
    word = "fails" if failing.fails else "warns"
    return f"the first stage that {word} is {failing.stage.name}: {failing.text}"


def describe(heard: Sequence[Heard], *, values: bool) -> str:
    """A line for each stage, `values` below it, and the conclusion."""
    lines = []
    for one in heard:
        mark = MARKS[Level.ERROR] if one.fails else MARKS[one.level]
        lines.append(f"{mark} {one.stage.name:<10} {one.text}")
        if values:
            lines += [f"    {entry.name}: {key} = {value}" for entry in one.entries for key, value in entry.values]
    return "\n".join([*lines, "", conclusion(heard)])


def as_json(heard: Sequence[Heard]) -> str:
    """docs/how-to/check_the_installation.md describes it."""
    failing = first_failing(heard)
    content = {
        "first": None if failing is None else failing.stage.name,
        "fails": failing is not None and failing.fails,
        "conclusion": conclusion(heard),
        "stages": [
            {
                "name": one.stage.name,
                "level": one.level.name,
                "text": one.text,
                "values": {entry.name: dict(entry.values) for entry in one.entries},
            }
            for one in heard
        ],
    }
    return json.dumps(content, indent=1)
