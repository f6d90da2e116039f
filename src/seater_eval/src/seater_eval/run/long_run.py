"""Jobs that take minutes: what is done is kept on disk; an interrupted run says how far it came, and the next one goes on."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from seater_eval.perception import subject
from seater_eval.run.parallel import run_jobs
from seater_eval.run.partial import PartialResults, fingerprint

INTERRUPTED = 130  # exit code, as shells have it


class _Counted(PartialResults):
    """Knows how many it holds."""

    def __init__(self, path: Path, key: str) -> None:
        super().__init__(path, key)
        self.count = len(self.done)

    def add(self, index: int, result: Any) -> None:
        super().add(index, result)
        self.count += 1


def run_long(
    function: Callable[[Any], Any], jobs: Sequence[Any], *, label: str, config: str | Path, partial: Path | None
) -> list[Any]:
    """As run_jobs. `partial`: file that keeps results until all are there; None: nowhere. They count for the same jobs with the
    same code, library and configuration only. Ctrl-C and SIGTERM end the program with exit code 130 and a line that tells how
    far it came."""
    if partial is None:
        return run_jobs(function, jobs, label=label)
    keep = _Counted(partial, fingerprint(jobs, [*Path(config).rglob("*.yaml"), *subject.library_files()]))
    with _told(lambda: f"{keep.count} of {len(jobs)} parts are kept in {partial}; the same command goes on from there"):
        return run_jobs(function, jobs, label=label, keep=keep)


@contextmanager
def _told(how_far: Callable[[], str]) -> Iterator[None]:
    def end(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    except KeyboardInterrupt:
        print(f"\ninterrupted: {how_far()}")
        raise SystemExit(INTERRUPTED) from None
    finally:
        signal.signal(signal.SIGTERM, before)
