import math
from types import SimpleNamespace

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_common.se2 import compose
from seater_eval.docking.dock_figure import draw_docking
from seater_eval.docking.recording import Recording, pose_at
from seater_eval.docking.summary import summarize, table

DEG = math.pi / 180.0
T_ODOM_DOCK = np.array([3.0, -1.0, 0.7])


def straight_run(final=(0.002, -0.003, 0.2 * DEG), estimate_offset=(0.0, 0.0, 0.0), code=0) -> Recording:
    """From 2 m ahead of the dock to `final` in 10 s; odometry without error, the dock estimated with an offset."""
    time = np.linspace(100.0, 110.0, 201)
    share = np.clip((time - 100.0) / 9.0, 0.0, 1.0)[:, None]
    poses = np.array([-2.0, 0.0, 0.0]) * (1 - share) + np.array(final) * share
    speed = np.where(time < 109.0, 2.0 / 9.0, 0.0)
    odom = np.array([compose(T_ODOM_DOCK, pose) for pose in poses])
    dock = compose(T_ODOM_DOCK, estimate_offset)
    images = np.column_stack([time, np.ones_like(time), np.arange(201) >= 20, np.full(201, 0.010)])
    control = np.column_stack([time, np.full(201, 0.005), np.full(201, 9), np.zeros(201), speed, np.zeros(201)])
    return Recording(
        truth=np.column_stack([time, poses, speed, np.zeros_like(time)]),
        odom=np.column_stack([time, odom, speed, np.zeros_like(time)]),
        dock_in_odom=np.column_stack([time, np.tile(dock, (201, 1))]),
        images=images,
        control=control,
        commands=np.column_stack([time, speed, np.zeros_like(time)]),
        phases=[(100.0, "APPROACH"), (105.0, "FINAL"), (109.0, "VERIFY")],
        goal_time=100.0,
        result_time=109.5,
        result=SimpleNamespace(result_code=code, result_text="text", num_retries=0, contact=True),
    )


def test_true_error_is_the_final_pose_in_the_dock_frame() -> None:
    summary = summarize(straight_run(), Dock(), Chair())
    assert summary["docked"]
    assert summary["true_error"]["longitudinal_m"] == pytest.approx(0.002)
    assert summary["true_error"]["lateral_m"] == pytest.approx(-0.003)
    assert summary["true_error"]["position_m"] == pytest.approx(math.hypot(0.002, 0.003))
    assert summary["true_error"]["heading_deg"] == pytest.approx(0.2)
    assert summary["start_pose"]["x_m"] == pytest.approx(-2.0)
    assert summary["duration_s"] == pytest.approx(9.5)


def test_estimate_error_is_the_estimated_dock_in_the_true_dock_frame() -> None:
    summary = summarize(straight_run(estimate_offset=(0.004, -0.001, 0.01)), Dock(), Chair())
    error = summary["estimate_error"]
    assert error["longitudinal_m"] == pytest.approx(0.004, abs=1e-9)
    assert error["lateral_m"] == pytest.approx(-0.001, abs=1e-9)
    assert error["heading_deg"] == pytest.approx(math.degrees(0.01), abs=1e-6)


def test_perception_counts_and_solve_times() -> None:
    summary = summarize(straight_run(), Dock(), Chair())
    assert summary["perception"]["frames"] == 201 and summary["perception"]["detected"] == 181
    assert summary["perception"]["rate_hz"] == pytest.approx(20.0)
    assert summary["perception"]["latency_ms"]["median"] == pytest.approx(10.0)
    assert summary["solve_ms"]["p99"] == pytest.approx(5.0)


@pytest.mark.parametrize(
    "run",
    [
        straight_run(final=(0.012, 0.0, 0.0)),  # too far
        straight_run(final=(0.0, 0.0, math.radians(1.5))),  # turned
        straight_run(code=905),  # the action says no
    ],
)
def test_not_docked_unless_action_and_truth_agree(run: Recording) -> None:
    summary = summarize(run, Dock(), Chair())
    assert not summary["docked"]
    assert "NOT DOCKED" in table(summary)


def test_not_docked_while_moving() -> None:
    run = straight_run()
    run.truth[-1, 4] = 0.05
    assert not summarize(run, Dock(), Chair())["docked"]


def test_a_run_that_never_saw_the_dock_has_no_estimate() -> None:
    run = straight_run(code=904)
    run.dock_in_odom = run.dock_in_odom[:0]
    run.result = None
    summary = summarize(run, Dock(), Chair())
    assert summary["estimate_error"] is None and summary["result_code"] == 999
    assert "never estimated" in table(summary)


def test_smallest_clearance_is_that_of_the_docked_chair() -> None:
    summary = summarize(straight_run(final=(0.0, 0.0, 0.0)), Dock(), Chair())
    assert summary["min_clearance_m"] == pytest.approx(0.15)


def test_pose_at_interpolates_across_the_wrap() -> None:
    track = np.array([[0.0, 0.0, 0.0, 3.1], [1.0, 1.0, 2.0, -3.1]])
    x, y, heading = pose_at(track, 0.5)
    assert (x, y) == (0.5, 1.0)
    assert abs(heading) == pytest.approx(math.pi)


def test_the_figure_is_drawn(tmp_path) -> None:
    run = straight_run()
    draw_docking(run, summarize(run, Dock(), Chair()), Dock(), Chair(), tmp_path / "trajectory.png")
    assert (tmp_path / "trajectory.png").stat().st_size > 20_000


def test_a_backward_dock_is_judged_with_the_back_to_the_wall() -> None:
    run = straight_run(final=(0.002, -0.003, math.pi + 0.2 * DEG))
    summary = summarize(run, Dock(direction="backward"), Chair())
    assert summary["docked"] and summary["true_error"]["heading_deg"] == pytest.approx(0.2)
    assert not summarize(run, Dock(), Chair())["docked"]


def test_files_of_the_run_are_named() -> None:
    summary = summarize(straight_run(), Dock(), Chair())
    assert "dock file" not in table(summary)
    assert "/some/my_dock.yaml" in table(summary | {"files": {"dock": "/some/my_dock.yaml"}})
