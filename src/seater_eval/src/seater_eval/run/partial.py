"""Keeps results of a long run on disk as they come, for a later run with the same code and inputs."""

from __future__ import annotations

import hashlib
import importlib.util
import pickle
from collections.abc import Iterable
from pathlib import Path
from typing import Any, BinaryIO

# Hashed as a whole: a change that does not matter only costs a new run.
_PACKAGES = ("seater_common", "seater_nmpc", "seater_sim", "seater_eval")


def fingerprint(inputs: Any, files: Iterable[Path] = ()) -> str:
    """Of the packages' sources, of `inputs` (by its pickle) and of the contents of `files`."""
    digest = hashlib.sha256(pickle.dumps(inputs))
    for path in [*_sources(), *sorted(files)]:
        digest.update(str(path.name).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _sources() -> list[Path]:
    found: list[Path] = []
    for name in _PACKAGES:
        spec = importlib.util.find_spec(name)
        for folder in (spec.submodule_search_locations or []) if spec else []:
            found += sorted(Path(folder).rglob("*.py"))
    return found


class PartialResults:
    """The file `path`: a fingerprint, then (index, result) one after another, pickled; `done` holds them by index.

    A file with another fingerprint is replaced. Only the program that wrote it may read it: a pickle can run any code.
    """

    def __init__(self, path: Path, key: str) -> None:
        self._path = path
        self.done: dict[int, Any] = {}
        path.parent.mkdir(parents=True, exist_ok=True)
        end = self._read(key)
        self._file: BinaryIO = path.open("r+b" if end else "wb")
        if end:
            self._file.truncate(end)  # drops a last entry that was cut off in the middle
            self._file.seek(end)
        else:
            pickle.dump(key, self._file)
            self._file.flush()

    def _read(self, key: str) -> int:
        """Fills `done`; returns where the last complete entry ends, 0 when the file is missing or has another key."""
        if not self._path.exists():
            return 0
        with self._path.open("rb") as file:
            end = 0
            try:
                if pickle.load(file) != key:
                    return 0
                end = file.tell()
                while True:
                    index, result = pickle.load(file)
                    self.done[index], end = result, file.tell()
            except (EOFError, pickle.UnpicklingError, ValueError, TypeError, AttributeError, IndexError):
                return end

    def add(self, index: int, result: Any) -> None:
        """Keep one more result."""
        self.done[index] = result
        pickle.dump((index, result), self._file)
        self._file.flush()

    def close(self, *, finished: bool) -> None:
        """`finished`: no later run needs the file, which is removed."""
        self._file.close()
        if finished:
            self._path.unlink(missing_ok=True)
