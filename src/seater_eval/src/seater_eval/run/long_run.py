"""Jobs that take minutes: finished results are kept on disk, so that an interrupted run can be continued."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from seater_common.command.ending import INTERRUPTED
from seater_eval.run.parallel import Spread, run_jobs
from seater_eval.run.partial import PartialResults, fingerprint


def run_long(
    function: Callable[[Any], Any],
    jobs: Sequence[Any],
    *,
    label: str,
    files: Iterable[Path],
    partial: Path | None,
    inputs: Any = None,
    workers: int | None = None,
    spread: Spread | None = None,
) -> list[Any]:
    """run_jobs, with results that survive an interruption.

    Args:
        files: what the results depend on beside the packages' Python code: configuration, libraries.
        partial: file that keeps results until all are there; None: nothing is kept.
        inputs: kept results count for the same `inputs` only; None: for the same jobs.

    Ctrl-C and SIGTERM end the program with exit code 130 and a line that says how far it came.
    """
    if partial is None:
        return run_jobs(function, jobs, label=label, workers=workers, spread=spread)
    keep = PartialResults(partial, fingerprint(jobs if inputs is None else inputs, files))

    def progress() -> str:
        done = sum(index < len(jobs) for index in keep.done)
        return f"{done} of {len(jobs)} parts are kept in {partial}; the same command continues from there"

    with exit_when_interrupted(progress):
        return run_jobs(function, jobs, label=label, workers=workers, keep=keep, spread=spread)


@contextmanager
def exit_when_interrupted(progress: Callable[[], str]) -> Iterator[None]:
    """Ctrl-C and SIGTERM end the program with INTERRUPTED; `progress()` says how far it came."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    except KeyboardInterrupt:
        print(f"\ninterrupted: {progress()}")
        raise SystemExit(INTERRUPTED) from None
    finally:
        signal.signal(signal.SIGTERM, before)
