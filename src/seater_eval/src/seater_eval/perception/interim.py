"""What a long run has found so far, on disk as it comes: an interrupted run says how far it came."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

INTERRUPTED = 130  # exit code, as shells have it


class Interim:
    """results/<command>.partial.jsonl: one line for each result, {"part", "done", "of", "result"}. `finished` removes it."""

    def __init__(self, folder: str | Path, command: str) -> None:
        self.path = Path(folder) / f"{command}.partial.jsonl"
        self._done: dict[str, int] = {}
        self._of: dict[str, int] = {}

    def part(self, name: str, of: int) -> Callable[[Any], None]:
        """A function that takes each of the `of` results of this part."""
        if not self._of:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.write_text("")
        self._done[name], self._of[name] = 0, of

        def keep(result: Any) -> None:
            self._done[name] += 1
            entry = {"part": name, "done": self._done[name], "of": of, "result": result}
            with self.path.open("a") as file:
                file.write(json.dumps(entry, default=lambda value: value.tolist()) + "\n")

        return keep

    def progress(self) -> str:
        """How far each part came, for a person."""
        return ", ".join(f"{name}: {done} of {self._of[name]}" for name, done in self._done.items()) or "nothing done"

    def finished(self) -> None:
        """The results proper are written."""
        self.path.unlink(missing_ok=True)


@contextmanager
def told_when_interrupted(interim: Interim) -> Iterator[None]:
    """Ctrl-C and a request to end (SIGTERM) end the run with exit code 130, after saying how far it came and where that is."""

    def end(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    except KeyboardInterrupt:
        print(f"\ninterrupted; {interim.progress()}. Kept in {interim.path}")
        raise SystemExit(INTERRUPTED) from None
    finally:
        signal.signal(signal.SIGTERM, before)
