"""Many independent jobs over all cores. What comes out does not depend on how many workers there are."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any, TextIO, TypeVar

import numpy as np

from seater_eval.run.partial import PartialResults
from seater_eval.run.progress import progress_bar

Job = TypeVar("Job")
Result = TypeVar("Result")
Spread = Callable[[Callable[[Any], Any], Sequence[tuple[int, Any]]], Iterator[tuple[int, Any]]]

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
    stream: TextIO | None = None,
    keep: PartialResults | None = None,
    spread: Spread | None = None,
) -> list[Result]:
    """function(job) for every job, in the order of the jobs.

    Args:
        function: of a module (it is sent to other processes by name). It must take all randomness from its job.
        workers: processes; None: one per core. 1: everything in this process.
        label: what the progress bar counts.
        stream: of the progress bar; None: standard error.
        keep: results of an earlier run that was interrupted are taken from it, new ones go into it as they come.
        spread: who runs them instead of `workers` processes: spread(function, [(index, job), ...]) gives (index,
            result) as they come.

    Raises whatever `function` raises, in the caller.
    """
    results: dict[int, Any] = {} if keep is None else {i: r for i, r in keep.done.items() if i < len(jobs)}
    left = [(index, job) for index, job in enumerate(jobs) if index not in results]
    workers = min(workers or cores(), max(1, len(left)))
    with progress_bar(label, len(jobs), done=len(results), stream=stream) as progress:
        for index, result in _run(function, left, workers) if spread is None else spread(function, left):
            results[index] = result
            if keep is not None:
                keep.add(index, result)
            progress.update()
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
