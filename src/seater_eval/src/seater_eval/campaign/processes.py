"""Jobs over the cores of this machine, so that a job whose process dies (out of memory, a fault in compiled code) costs
its own result and no other."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from seater_eval.run.parallel import Spread

Function = Callable[[Any], Any]
Indexed = Sequence[tuple[int, Any]]

# Every worker is one thread: matrix libraries that start their own would only fight over the cores.
_ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def over_processes(workers: int, died: Callable[[Any], Any]) -> Spread:
    """A way to spread jobs (see run_jobs) over processes. `died(job)`: the result of a job whose process died."""

    def spread(function: Function, jobs: Indexed) -> Iterator[tuple[int, Any]]:
        for name in _ONE_THREAD:
            os.environ.setdefault(name, "1")
        left = list(reversed(jobs))
        while left:
            suspects: list[tuple[int, Any]] = []
            yield from _until_one_dies(function, left, workers, suspects)
            for index, job in suspects:  # each in a process of its own: which of them was it?
                yield index, _alone(function, job, died)

    return spread


def _pool(workers: int) -> ProcessPoolExecutor:
    # Forking a process with threads in it is not safe.
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def _until_one_dies(
    function: Function, left: list[tuple[int, Any]], workers: int, suspects: list[tuple[int, Any]]
) -> Iterator[tuple[int, Any]]:
    """Takes jobs from the end of `left`, no more at a time than there are workers; those that were under way when a
    process died go to `suspects`."""
    running: dict[Future[Any], tuple[int, Any]] = {}
    pool = _pool(workers)
    try:
        while (left or running) and not suspects:
            while left and len(running) < workers:
                running[pool.submit(function, left[-1][1])] = left[-1]
                left.pop()
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                entry = running.pop(future)
                try:
                    yield entry[0], future.result()
                except BrokenProcessPool:
                    suspects.append(entry)
    except BrokenProcessPool:  # raised by submit
        pass
    finally:
        suspects += running.values()
        pool.shutdown(wait=True, cancel_futures=True)


def _alone(function: Function, job: Any, died: Callable[[Any], Any]) -> Any:
    with _pool(1) as pool:
        try:
            return pool.submit(function, job).result()
        except BrokenProcessPool:
            return died(job)
