"""Many independent jobs over all cores. What comes out does not depend on how many workers there are."""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeVar

import numpy as np

from seater_eval.run.partial import PartialResults
from seater_eval.run.progress import ProgressLine

Job = TypeVar("Job")
Result = TypeVar("Result")

# Every worker is one thread: matrix libraries that start their own would only fight over the cores.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def job_seed(seed: int, index: int) -> int:
    """The seed of job `index`: depends on nothing else, so that one job can be run again alone."""
    return int(np.random.SeedSequence([seed, index]).generate_state(1, np.uint32)[0])


def run_jobs(
    function: Callable[[Job], Result],
    jobs: Sequence[Job],
    *,
    workers: int | None = None,
    label: str = "",
    progress: ProgressLine | None = None,
    keep: PartialResults | None = None,
) -> list[Result]:
    """function(job) for every job, in the order of the jobs.

    Args:
        function: of a module (it is sent to other processes by name). It must take all randomness from its job.
        workers: processes; None: one per core. 1: everything in this process.
        label: what the progress line says it counts.
        keep: results of an earlier run that was interrupted are taken from it, new ones go into it as they come.

    Raises whatever `function` raises, in the caller.
    """
    line = progress or ProgressLine()
    results: dict[int, Any] = {} if keep is None else {i: r for i, r in keep.done.items() if i < len(jobs)}
    tracker = _Tracker(line, label, len(jobs), len(results))
    left = [(index, job) for index, job in enumerate(jobs) if index not in results]
    for index, result in _run(function, left, min(workers or cores(), max(1, len(left)))):
        results[index] = result
        if keep is not None:
            keep.add(index, result)
        tracker.done()
    line.end()
    if keep is not None:
        keep.close(finished=True)
    return [results[index] for index in range(len(jobs))]


def _run(
    function: Callable[[Job], Result], jobs: Sequence[tuple[int, Job]], workers: int
) -> Iterator[tuple[int, Result]]:
    """(index, result) as they come."""
    if workers == 1:
        yield from ((index, function(job)) for index, job in jobs)
        return
    for name in _ONE_THREAD:
        os.environ.setdefault(name, "1")
    context = multiprocessing.get_context("spawn")  # forking a process with threads in it is not safe
    with context.Pool(workers) as pool:
        yield from pool.imap_unordered(_call, ((function, index, job) for index, job in jobs))


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def _call(task: tuple[Callable[[Any], Any], int, Any]) -> tuple[int, Any]:
    function, index, job = task
    return index, function(job)


class _Tracker:
    """Counts what is done and shows rate and remaining time."""

    def __init__(self, line: ProgressLine, label: str, total: int, before: int = 0) -> None:
        """`before`: how many are done already, by an earlier run."""
        self._line, self._label, self._total = line, label, total
        self._done, self._before, self._start = before, before, time.monotonic()

    def done(self) -> None:
        self._done += 1
        self._line.show(self.text(time.monotonic() - self._start), always=self._done == self._total)

    def text(self, elapsed: float) -> str:
        """The line after `elapsed` seconds."""
        rate = (self._done - self._before) / max(elapsed, 1e-9)
        left = (self._total - self._done) / rate
        filled = round(20 * self._done / self._total)
        bar = "#" * filled + "." * (20 - filled)
        return f"{self._label} [{bar}] {self._done}/{self._total}  {rate:.2f}/s  {format_time(left)} left"


class StepProgress:
    """The same line for work that is done one after another in this process."""

    def __init__(self, label: str, total: int, progress: ProgressLine | None = None) -> None:
        self._line = progress or ProgressLine()
        self._tracker = _Tracker(self._line, label, total)

    def done(self) -> None:
        """One more is finished."""
        self._tracker.done()

    def end(self) -> None:
        """All are."""
        self._line.end()


def format_time(seconds: float) -> str:
    """1:05, or 2:03:00 from an hour on."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"
