"""Jobs over the workers of a Dask cluster. Dask is an optional extra: it is imported only here."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from seater_common.params import ParameterError
from seater_eval.run.parallel import Spread

Function = Callable[[Any], Any]
Indexed = Sequence[tuple[int, Any]]


def over_dask(address: str, died: Callable[[Any], Any]) -> Spread:
    """A way to spread jobs (see run_jobs) over the cluster whose scheduler is at `address` (tcp://host:8786).

    The workers need the same release of this project (`./seater shell`, then `dask worker ADDRESS --nthreads 1`); files
    of this machine they do not need. `died(job)`: the result of a job that killed worker after worker.

    Raises ParameterError when Dask is not installed or there is no scheduler.
    """
    try:
        distributed = importlib.import_module("distributed")
    except ImportError as error:
        raise ParameterError(
            "--scheduler: needs Dask, which is not installed here (pip install -r tools/requirements_campaign.txt)"
        ) from error
    try:
        client = distributed.Client(address, timeout="10s", set_as_default=False)
    except (OSError, ValueError) as error:
        raise ParameterError(f"--scheduler: no Dask scheduler at {address!r}: {error}") from error

    def spread(function: Function, jobs: Indexed) -> Iterator[tuple[int, Any]]:
        # pure=False: nothing is taken from an earlier call; a job is not kept as soon as its result is here.
        futures = {client.submit(function, job, pure=False): (index, job) for index, job in jobs}
        try:
            for future in distributed.as_completed(list(futures), loop=client.loop):
                index, job = futures.pop(future)
                yield index, _result(distributed, future, job, died)
        finally:
            client.cancel(list(futures))
            client.close()

    return spread


def _result(distributed: Any, future: Any, job: Any, died: Callable[[Any], Any]) -> Any:
    try:
        return future.result()
    except distributed.KilledWorker:
        return died(job)
