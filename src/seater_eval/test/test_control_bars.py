"""Bars of the controller's commands, judged on made-up runs."""

from pathlib import Path

import pytest
from made_up_runs import synthetic_run

from seater_eval.control.campaign_summary import campaign_bars, summarize_runs
from seater_eval.control.docking_table import TABLE_II, table_bars
from seater_eval.control.solver_benchmark import benchmark_bars
from seater_eval.report.bars import all_met
from seater_sim.settings import KINEMATIC, WHEELCHAIR

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.mark.parametrize(
    ("changes", "bar"),
    [
        ({"docked": False, "result": "TIMEOUT"}, "not docked"),
        ({"collisions": 1}, "collided"),
        ({"limits_violated": True}, "limits violated"),
        ({"position_error_m": 0.2}, "true position error, 95th percentile"),
        ({"heading_error_deg": 3.0}, "true heading error, 95th percentile"),
        ({"out_of_view_s": 0.6}, "markers out of view for more than 0.5 s"),
    ],
)
def test_one_bad_run_in_ten_fails_its_bar_and_no_other(changes: dict, bar: str) -> None:
    good = [synthetic_run() for _ in range(1000)]
    assert all_met(campaign_bars({"summary": summarize_runs(good)}, quick=False))
    bad = [*good[:900], *(synthetic_run(**changes) for _ in range(100))]
    bars = campaign_bars({"summary": summarize_runs(bad)}, quick=False)
    assert [b.name for b in bars if not b.met] == [bar]


def test_slow_or_too_few_runs_fail() -> None:
    slow = {"summary": summarize_runs([synthetic_run(docking_time_s=14.0) for _ in range(1000)])}
    assert [b.name for b in campaign_bars(slow, False) if not b.met] == ["docking time / minimum time, median"]
    few = {"summary": summarize_runs([synthetic_run() for _ in range(999)])}
    assert [b.name for b in campaign_bars(few, False) if not b.met] == ["runs"]
    unseen = {"summary": summarize_runs([synthetic_run(started_in_view=False, out_of_view_s=3.0)] * 1000)}
    assert all_met(campaign_bars(unseen, False))  # only runs that started in view count


def test_a_wheelchair_may_take_longer_and_end_a_little_more_askew() -> None:
    runs = {"summary": summarize_runs([synthetic_run(docking_time_s=14.0, heading_error_deg=0.55)] * 1000)}
    assert all_met(campaign_bars(runs, False, WHEELCHAIR))
    assert sum(not bar.met for bar in campaign_bars(runs, False, KINEMATIC)) == 2


def test_docking_table_judges_the_worst_pose() -> None:
    runs = [{"position_error_m": 1e-7, "heading_error_deg": 1e-6} for _ in TABLE_II]
    assert all_met(table_bars({"runs": {"seater": runs}}))
    runs[2] = {"position_error_m": 1.1e-5, "heading_error_deg": 1e-6}
    assert [bar.met for bar in table_bars({"runs": {"seater": runs}})] == [False, True]


def benchmark_rows(**p99: float) -> dict:
    rows = [
        {"solver": name, "horizon": N, "solve_cpu_ms": {"median": N * value / 30.0, "p99": value}}
        for name, value in p99.items()
        for N in (20, 30, 80)
    ]
    missing = [name for name in ("rti", "fatrop") if name not in p99]
    return {"rows": rows, "missing_solvers": missing, "available_solvers": list(p99)}


def test_benchmark_bars_are_ratios_of_this_run() -> None:
    assert all_met(benchmark_bars(benchmark_rows(rti=1.0, fatrop=3.1, ipopt_default=16.0)))
    bars = benchmark_bars(benchmark_rows(rti=1.0, fatrop=2.9, ipopt_default=14.0))
    assert [bar.met for bar in bars] == [False, False, True]
    assert [bar.value for bar in bars] == pytest.approx([14.0, 2.9, 4.0])


def test_a_missing_solver_leaves_its_bars_unmet_and_says_so() -> None:
    bars = benchmark_bars(benchmark_rows(ipopt_default=16.0))
    assert not any(bar.met for bar in bars)
    assert all("not available: rti, fatrop" in bar.note for bar in bars)
