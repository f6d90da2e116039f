"""The docks of the database, each with the core that docks there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import rospy

from seater_common.files.docks import DockDatabase, DockEntry, read_folder
from seater_common.params import ParameterError

C = TypeVar("C")


def read_docks() -> DockDatabase:
    """The dock of ~dock and, where ~docks names a folder, one for each of its files.

    Raises:
        ParameterError: a dock is wrong, or images cannot tell two of them apart.
    """
    key = rospy.resolve_name("~dock")
    configured = DockEntry.of(rospy.get_param("~dock", None), key)
    folder: Any = rospy.get_param("~docks", "")
    others = read_folder(str(folder)) if folder else []
    try:
        database = DockDatabase(configured, others)
    except ParameterError as error:
        raise ParameterError(
            f"{error}\n({key} is the launch argument dock_file: mostly a file of the folder)"
        ) from error
    if database.replaced is not None:
        path = database.entry("").source
        rospy.logwarn("%s differs from %s, which is used", database.replaced.source, path)
    return database


@dataclass(frozen=True)
class Loaded(Generic[C]):
    """What was read at one time, ready to be used."""

    database: DockDatabase
    cores: dict[str, C]
    revisions: dict[str, int]  # of all docks that there were, see DockInUse.msg


class Docks(Generic[C]):
    """`take` and everything that reads belong to one thread; `load` changes nothing and may run in another."""

    def __init__(self, read: Callable[[], DockDatabase], make: Callable[[DockEntry], C]) -> None:
        """`read`: the database as it is now; `make`: the core for a dock. Raises ValueError, as both do."""
        self._read, self._make = read, make
        self._loaded: Loaded[C] | None = None
        self.take(self.load())

    def load(self) -> Loaded[C]:
        """Read anew; a dock that has not changed keeps its core, and what that has learned. Raises ValueError."""
        database, before = self._read(), self._loaded
        cores, revisions = {}, dict(before.revisions) if before else {}
        for entry in database:
            name = entry.dock.name
            if before is not None and name in before.cores and before.database.entry(name).dock == entry.dock:
                cores[name] = before.cores[name]
                continue
            cores[name] = self._make(entry)
            # Others may have been started with the content that was replaced.
            replaced = name == database.configured and database.replaced is not None
            revisions[name] = revisions[name] + 1 if name in revisions else int(replaced)
        return Loaded(database, cores, revisions)

    def take(self, loaded: Loaded[C]) -> None:
        """From now on these are the docks."""
        self._loaded = loaded

    @property
    def database(self) -> DockDatabase:
        """Names, and where each was read."""
        return self._now.database

    def core(self, name: str = "") -> C:
        """For the dock of this name; empty: the configured one. Raises UnknownDockError."""
        return self._now.cores[self.database.entry(name).dock.name]

    def cores(self) -> list[C]:
        """Of all docks."""
        return list(self._now.cores.values())

    def revision(self, name: str) -> int:
        """How often it was loaded with another content. Raises KeyError."""
        return self._now.revisions[name]

    @property
    def _now(self) -> Loaded[C]:
        assert self._loaded is not None  # set on construction
        return self._loaded
