"""Several docks, of which a goal names one: the configured dock, and a folder with one dock file for each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from seater_common.geometry import Dock
from seater_common.params import ParameterError, load, read_yaml


class UnknownDockError(ValueError):
    """No dock has this name; the text names those that there are."""


@dataclass(frozen=True)
class DockEntry:
    """One dock, and where it was read."""

    dock: Dock
    source: str  # a file, or a key of the parameter server
    content: str  # the same as YAML, for whoever reads other keys of it

    @staticmethod
    def of(values: Any, source: str) -> DockEntry:
        """From the nested mapping of a dock file. Raises ParameterError."""
        dock = load(Dock, values, source)
        return DockEntry(dock, source, yaml.safe_dump(_plain(values), sort_keys=True))


class DockDatabase:
    """Docks by their names, in ascending order but for the configured one, which comes first."""

    def __init__(self, configured: DockEntry, others: Sequence[DockEntry] = ()) -> None:
        """An entry of `others` that has the configured dock's name takes its place.

        Raises:
            ParameterError: two docks have the same name, or images cannot tell them apart; names both keys.
        """
        self.configured = configured.dock.name
        found = {entry.dock.name: entry for entry in others}
        first = found.get(self.configured, configured)
        entries = [first, *(entry for entry in sorted(others, key=_name) if entry is not first)]
        problems = [*_same_names(entries), *_same_markers(entries)]
        if problems:
            raise ParameterError("wrong docks:\n  " + "\n  ".join(problems))
        self._entries = {entry.dock.name: entry for entry in entries}
        self.replaced = configured if first.dock != configured.dock else None  # by an entry of the same name

    @property
    def names(self) -> list[str]:
        """Of all docks."""
        return list(self._entries)

    def __iter__(self) -> Iterator[DockEntry]:
        return iter(self._entries.values())

    def entry(self, name: str) -> DockEntry:
        """The dock of this name; empty: the configured one. Raises UnknownDockError."""
        found = self._entries.get(name or self.configured)
        if found is None:
            raise UnknownDockError(f"no dock {name!r}; known are {', '.join(self.names)}")
        return found


def read_folder(folder: str | Path) -> list[DockEntry]:
    """One entry for each *.yaml file in the folder.

    Raises:
        ParameterError: there is no such folder, it has no such file, or a file is wrong; names every wrong file.
    """
    files = sorted(Path(folder).expanduser().glob("*.yaml"))
    if not files:
        raise ParameterError(f"{folder}: must be a folder with at least one dock file (*.yaml)")
    entries, problems = [], []
    for file in files:
        try:
            entries.append(DockEntry.of(read_yaml(file), str(file)))
        except ParameterError as error:
            problems.append(str(error))
    if problems:
        raise ParameterError("\n".join(problems))
    return entries


def read_content(content: str, source: str) -> Dock:
    """The dock of an entry's content. Raises ParameterError, with `source` in its text."""
    try:
        return load(Dock, yaml.safe_load(content), source)
    except yaml.YAMLError as error:
        raise ParameterError(f"{source}: {error}") from error


def _name(entry: DockEntry) -> str:
    return entry.dock.name


def _same_names(entries: list[DockEntry]) -> Iterator[str]:
    known: dict[str, DockEntry] = {}
    for entry in entries:
        other = known.setdefault(entry.dock.name, entry)
        if other is not entry:
            yield f"{entry.source}/name: is {entry.dock.name!r}, which {other.source}/name is, too: each needs its own"


def _same_markers(entries: list[DockEntry]) -> Iterator[str]:
    """A print that hangs at two docks: an image of it does not say which of them it shows, nor how large it is there,
    so the chair would drive by the wrong one's measures."""
    if len(entries) < 2:
        return
    # Here, as OpenCV takes a third of the docking node's time to start, and one dock needs none of it.
    from seater_common.marker_family import marker_family

    known: dict[tuple[int, bytes], str] = {}
    for entry in entries:
        for i, marker in enumerate(entry.dock.markers):
            key = f"{entry.source}/markers[{i}]/id"
            try:
                cells = marker_family(entry.dock.dictionary).print_of(marker.id)
            except ValueError as error:
                yield f"{entry.source}/{error}"
                break
            other = known.setdefault((len(cells), cells.tobytes()), key)
            if other is not key:
                yield (
                    f"{key}: is {marker.id} of {entry.dock.dictionary}, the same print as {other}: images cannot tell "
                    "the docks apart; give each dock ids of its own, and docks that are alike one file together"
                )


def _plain(values: Any) -> Any:
    """Without types that only the parameter server or a reader knows."""
    if isinstance(values, Mapping):
        return {str(key): _plain(value) for key, value in values.items()}
    if isinstance(values, list | tuple):
        return [_plain(value) for value in values]
    return values
