"""Entries of /diagnostics by stage, as diagnostic_aggregator's GenericAnalyzer sorts them; the first that fails."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

from seater_common.params import ParameterError, read_yaml

# As in config/diagnostics.yaml: data pass them in this order.
ORDER = ("camera", "detection", "pose", "observer", "solver", "sequence", "obstacles", "gate", "base", "inputs")
TIMEOUT = 5.0  # [s] GenericAnalyzer's own


class Level(IntEnum):
    """The numbers of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Entry:
    """The newest word of one entry. `age` [s] since it came."""

    name: str  # NODE: STAGE
    level: Level
    text: str
    age: float = 0.0
    values: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Stage:
    """An analyzer of config/diagnostics.yaml."""

    name: str
    contains: tuple[str, ...]
    expected: tuple[str, ...] = ()
    timeout: float = TIMEOUT


@dataclass(frozen=True)
class Heard:
    """What was said of a stage. Without any entry, and none expected, nobody knows it, which is no fault."""

    stage: Stage
    entries: tuple[Entry, ...]
    silent: tuple[str, ...] = ()  # entries that are expected and did not come, or are too old

    @property
    def level(self) -> Level:
        """The worst; STALE: silent, or nobody knows."""
        if self.silent or not self.entries:
            return Level.STALE
        return max(entry.level for entry in self.entries)

    @property
    def fails(self) -> bool:
        """Nothing can dock."""
        return bool(self.silent) or self.level is Level.ERROR

    @property
    def text(self) -> str:
        """The worst that was said, with who said it; cause and remedy are in it."""
        worst = max(self.entries, key=lambda entry: entry.level, default=None)
        if worst is not None and worst.level is Level.ERROR:
            return f"{worst.name.rpartition(': ')[0]} says: {worst.text}"
        if self.silent:
            name = self.silent[0]
            return f"{name!r} is silent: does the node {name.rpartition(': ')[0]} run? (rosnode list, its log)"
        if worst is None:
            return "nobody says anything"
        if worst.level:
            return f"{worst.name.rpartition(': ')[0]} says: {worst.text}"
        return "; ".join(f"{entry.name.rpartition(': ')[0]}: {entry.text}" for entry in self.entries)


def read_stages(path: Path) -> tuple[Stage, ...]:
    """The analyzers of a file for diagnostic_aggregator, in their order. Raises ParameterError."""
    content: Any = read_yaml(path)
    analyzers = content.get("analyzers") if isinstance(content, dict) else None
    if not isinstance(analyzers, dict) or not analyzers:
        raise ParameterError(f"{path}: analyzers: must be a mapping")
    stages = []
    for key, value in analyzers.items():
        if not isinstance(value, dict) or not isinstance(value.get("path"), str) or not value.get("contains"):
            raise ParameterError(f"{path}: analyzers/{key}: needs path and contains")
        contains, expected = (_texts(path, f"{key}/{name}", value.get(name, [])) for name in ("contains", "expected"))
        timeout = value.get("timeout", TIMEOUT)
        if not isinstance(timeout, int | float) or not timeout > 0.0:
            raise ParameterError(f"{path}: analyzers/{key}/timeout: is {timeout!r}, must be above 0")
        stages.append(Stage(value["path"], contains, expected, float(timeout)))
    return tuple(stages)


def _texts(path: Path, key: str, value: Any) -> tuple[str, ...]:
    found = [value] if isinstance(value, str) else value
    if not isinstance(found, list) or not all(isinstance(text, str) for text in found):
        raise ParameterError(f"{path}: analyzers/{key}: must be a text or a list of texts")
    return tuple(found)


def sort(stages: Sequence[Stage], entries: Iterable[Entry]) -> list[Heard]:
    """The tree: what was said of each stage."""
    entries, heard = list(entries), []
    for stage in stages:
        mine = [entry for entry in entries if any(part in entry.name for part in stage.contains)]
        fresh = {entry.name: entry for entry in mine if entry.age <= stage.timeout and entry.level is not Level.STALE}
        old = [entry.name for entry in mine if entry.name not in fresh]
        silent = [*(name for name in stage.expected if name not in fresh and name not in old), *old]
        heard.append(Heard(stage, tuple(fresh.values()), tuple(silent)))
    return heard


def first_failing(heard: Sequence[Heard]) -> Heard | None:
    """The first in order that fails, or else warns; None: all is well."""
    warns = (one for one in heard if one.level is Level.WARN)
    return next((one for one in heard if one.fails), next(warns, None))


def stage_of(name: str) -> int:
    """Place in ORDER of an entry's stage, for those who sort; behind all others: of none."""
    last = name.rpartition(": ")[2]
    return ORDER.index(last) if last in ORDER else len(ORDER)
