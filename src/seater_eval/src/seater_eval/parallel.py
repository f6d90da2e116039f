"""Many independent jobs over all cores. What comes out does not depend on how many workers there are."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from seater_eval.progress import ProgressLine

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
    keep: Callable[[Result], None] | None = None,
) -> list[Result]:
    """function(job) for every job, in the order of the jobs.

    Args:
        function: of a module (it is sent to other processes by name). It must take all randomness from its job.
        workers: processes; None: one per core. 1: everything in this process.
        label: what the progress line says it counts.
        keep: called in this process with each result as it comes, in whatever order.

    Raises whatever `function` raises, in the caller.
    """
    line = progress or ProgressLine()
    tracker = _Tracker(line, label, len(jobs))
    workers = min(workers or cores(), max(1, len(jobs)))
    results: list[Any] = [None] * len(jobs)
    if workers == 1:
        for index, job in enumerate(jobs):
            results[index] = function(job)
            if keep is not None:
                keep(results[index])
            tracker.done()
    else:
        for name in _ONE_THREAD:
            os.environ.setdefault(name, "1")
        context = multiprocessing.get_context("spawn")  # forking a process with threads in it is not safe
        with context.Pool(workers, _leave_interrupts_to_the_parent) as pool:
            calls = ((function, index, job) for index, job in enumerate(jobs))
            for index, result in pool.imap_unordered(_call, calls):
                results[index] = result
                if keep is not None:
                    keep(result)
                tracker.done()
    line.end()
    return results


def _leave_interrupts_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def _call(task: tuple[Callable[[Any], Any], int, Any]) -> tuple[int, Any]:
    function, index, job = task
    return index, function(job)


class _Tracker:
    """Counts what is done and shows rate and remaining time."""

    def __init__(self, line: ProgressLine, label: str, total: int) -> None:
        self._line, self._label, self._total = line, label, total
        self._done, self._start = 0, time.monotonic()

    def done(self) -> None:
        self._done += 1
        self._line.show(self.text(time.monotonic() - self._start), always=self._done == self._total)

    def text(self, elapsed: float) -> str:
        """The line after `elapsed` seconds."""
        rate = self._done / max(elapsed, 1e-9)
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
