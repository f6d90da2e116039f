import numpy as np
import pytest

from seater_eval.baselines.trajectories import Trajectory, quickest


def run(cpu: list[float], command: float = 0.1) -> Trajectory:
    n = len(cpu)
    wall = np.array(cpu) + 1.0
    return Trajectory(
        times=np.arange(n + 1.0), poses=np.zeros((n + 1, 3)), speeds=np.zeros((n + 1, 2)),
        commands=np.full((n, 2), command), cycle_times=wall, cycle_cpu=np.array(cpu), solve_times=wall,
        solve_cpu=np.array(cpu),
    )  # fmt: skip


def test_each_cycle_counts_at_its_shortest() -> None:
    both = quickest([run([1.0, 9.0, 2.0]), run([4.0, 3.0, 2.5], command=0.1 + 1e-8)])
    for of in (both.cycle_cpu, both.solve_cpu):
        np.testing.assert_array_equal(of, [1.0, 3.0, 2.0])
    for of in (both.cycle_times, both.solve_times):
        np.testing.assert_array_equal(of, [2.0, 4.0, 3.0])


def test_different_runs_are_not_compared() -> None:
    with pytest.raises(ValueError, match="differ"):
        quickest([run([1.0, 2.0]), run([1.0, 2.0], command=0.2)])
    with pytest.raises(ValueError, match="differ"):
        quickest([run([1.0, 2.0]), run([1.0])])
