import io

import numpy as np
import pytest

from seater_eval.run.parallel import job_seed, run_jobs
from seater_eval.run.progress import progress_bar


def noisy_sum(job: tuple[int, int]) -> float:
    """A job that uses its own random numbers; a module's function, because it goes to other processes."""
    seed, count = job
    return float(np.random.default_rng(seed).standard_normal(count).sum())


def failing(job: int) -> int:
    if job == 2:
        raise ValueError("job 2 is bad")
    return job


def test_results_do_not_depend_on_the_number_of_workers() -> None:
    jobs = [(job_seed(5, index), 10 + index % 3) for index in range(9)]
    alone = run_jobs(noisy_sum, jobs, workers=1, stream=io.StringIO())
    together = run_jobs(noisy_sum, jobs, workers=2, stream=io.StringIO())
    assert alone == together
    assert len(set(alone)) == 9  # every job has random numbers of its own, in its own place


def test_seeds_differ_between_jobs_and_campaigns_only() -> None:
    seeds = [job_seed(seed, index) for seed in (1, 2) for index in range(100)]
    assert len(set(seeds)) == 200
    assert job_seed(1, 7) == job_seed(1, 7)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_reaches_the_caller(workers: int) -> None:
    with pytest.raises(ValueError, match="job 2 is bad"):
        run_jobs(failing, [1, 2, 3], workers=workers, stream=io.StringIO())


def test_a_log_gets_count_and_rate_on_lines_of_their_own() -> None:
    stream = io.StringIO()
    run_jobs(failing, [0, 1], workers=1, label="things", stream=stream)
    lines = stream.getvalue().splitlines()
    assert all(line.startswith("things:") for line in lines) and "\r" not in stream.getvalue()
    assert "0/2" in lines[0] and "2/2" in lines[-1]


def test_parts_of_an_earlier_run_count_as_done() -> None:
    stream = io.StringIO()
    with progress_bar("parts", 4, done=3, stream=stream) as progress:
        progress.update()
    assert "3/4" in stream.getvalue() and "4/4" in stream.getvalue()
