import io

import numpy as np
import pytest

from seater_eval.run.parallel import format_time, job_seed, run_jobs
from seater_eval.run.progress import ProgressLine


def noisy_sum(job: tuple[int, int]) -> float:
    """A job that uses its own random numbers; a module's function, because it goes to other processes."""
    seed, count = job
    return float(np.random.default_rng(seed).standard_normal(count).sum())


def failing(job: int) -> int:
    if job == 2:
        raise ValueError("job 2 is bad")
    return job


def quiet() -> ProgressLine:
    return ProgressLine(io.StringIO())


def test_results_do_not_depend_on_the_number_of_workers() -> None:
    jobs = [(job_seed(5, index), 10 + index % 3) for index in range(9)]
    alone = run_jobs(noisy_sum, jobs, workers=1, progress=quiet())
    together = run_jobs(noisy_sum, jobs, workers=2, progress=quiet())
    assert alone == together
    assert len(set(alone)) == 9  # every job has random numbers of its own, in its own place


def test_seeds_differ_between_jobs_and_campaigns_only() -> None:
    seeds = [job_seed(seed, index) for seed in (1, 2) for index in range(100)]
    assert len(set(seeds)) == 200
    assert job_seed(1, 7) == job_seed(1, 7)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_reaches_the_caller(workers: int) -> None:
    with pytest.raises(ValueError, match="job 2 is bad"):
        run_jobs(failing, [1, 2, 3], workers=workers, progress=quiet())


def test_progress_shows_count_rate_and_remaining_time() -> None:
    stream = io.StringIO()
    run_jobs(failing, [0, 1], workers=1, label="things", progress=ProgressLine(stream))
    assert "things [" in stream.getvalue() and "2/2" in stream.getvalue() and "0:00 left" in stream.getvalue()
    assert format_time(65.4) == "1:05" and format_time(7380.0) == "2:03:00"
