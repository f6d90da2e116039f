import csv

import numpy as np
import pytest

from seater_eval.docking.replay_log import CycleRow, ImageRow, replay_table, summarize_replay, write_csv


def images(count: int = 2000, sd: float = 0.002, missed: range = range(0)) -> list[ImageRow]:
    random = np.random.default_rng(3)
    rows = []
    for i in range(count):
        if i in missed:
            rows.append(ImageRow(i / 30, 0, 0, None, None, None, None, 5.0))
            continue
        x, y = random.normal(0.0, sd, 2)
        rows.append(ImageRow(i / 30, 1, 1, 1.0 + x, y, 3.14159 if i % 2 else -3.14159, 0.001, 5.0))
    return rows


def test_jitter_is_the_standard_deviation_of_white_noise_whatever_the_wrap_does() -> None:
    jitter = summarize_replay(images(sd=0.002), [], 2000)["pose_jitter"]
    assert jitter["position_m"] == pytest.approx(0.002 * np.sqrt(2), rel=0.05)
    assert jitter["heading_deg"] < 0.001


def test_detection_rate_and_longest_gap() -> None:
    summary = summarize_replay(images(300, missed=range(100, 130)), [], 310)
    assert summary["detection_rate"] == pytest.approx(0.9)
    assert summary["longest_gap_s"] == pytest.approx(31 / 30)
    assert summary["images_in_bag"] == 310 and summary["images_worked_through"] == 300


def test_shadow_controller_is_compared_with_the_recording() -> None:
    cycles = [
        CycleRow(0.0, "FINAL", 0, 4.0, 8, 0.3, 0.1, 0.2, 0.1),
        CycleRow(0.1, "FINAL", 0, 6.0, 8, -0.4, 0.1, None, None),
    ]
    shadow = summarize_replay(images(10), cycles, 10)["shadow_controller"]
    assert shadow["v_max"] == 0.4 and shadow["v_rms_difference"] == pytest.approx(0.1)
    assert shadow["omega_rms_difference"] == pytest.approx(0.0)


def test_nothing_seen_is_a_result_too() -> None:
    summary = summarize_replay(images(50, missed=range(50)), [], 50)
    assert summary["pose_jitter"] is None and summary["detection_rate"] == 0.0
    assert "0.0 %" in replay_table(summary)


def test_csv_keeps_full_precision_and_leaves_unmeasured_fields_empty(tmp_path) -> None:
    rows = images(3, missed=range(1, 2))
    write_csv(tmp_path / "p.csv", rows, ImageRow)
    with (tmp_path / "p.csv").open() as file:
        read = list(csv.DictReader(file))
    assert float(read[0]["dock_x"]) == rows[0].dock_x
    assert read[1]["dock_x"] == "" and read[1]["markers"] == "0"
