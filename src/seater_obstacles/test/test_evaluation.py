"""The evaluation sees what it is for: a blind chair runs into things, one with a sensor does not."""

from pathlib import Path

import numpy as np
import pytest

from seater_common.geometry import Chair, polygon_distance
from seater_obstacles.evaluation.campaign import bars, describe, run_cases, summarize
from seater_obstacles.evaluation.cases import CASES, draw_scene
from seater_sim.settings import SimulatorSettings

CONFIG = Path(__file__).resolve().parents[3] / "config"
IN_THE_WAY = 3  # a seed whose box stands on the straight way


@pytest.mark.extensive  # the nodes drive round one always: obstacle_seen.test
def test_a_blind_chair_runs_into_the_box_that_a_seeing_one_drives_round() -> None:
    blind, seeing = (
        run_cases(CONFIG, ("box",), 1, sensor="scan", watched=watched, seed=IN_THE_WAY, workers=1)
        for watched in (False, True)
    )
    assert blind["cases"][0]["summary"]["touched_driving"] == 1
    summary = seeing["cases"][0]["summary"]
    assert summary["touched"] == 0 and summary["docked_by_the_first_goal"] == 1
    assert all(bar.met for bar in bars(seeing)) and not all(bar.met for bar in bars(blind))
    assert "1 of 1" in describe(seeing)


@pytest.mark.parametrize("case", CASES)
def test_scenes_begin_clear_of_everything(case: str) -> None:
    chair = Chair()
    for seed in range(30):
        scene = draw_scene(case, "scan", SimulatorSettings(), chair, np.random.default_rng(seed))
        assert scene.settings.ranging.kind == "scan"
        for thing in scene.settings.obstacles:
            assert polygon_distance(chair.corners_at(scene.start), thing.polygon()) > 0.4
        assert len(scene.settings.walkers) == (case == "person")


def test_a_touch_counts_even_when_it_is_slow() -> None:
    run = {
        "touches": [{"at_s": 1.0, "v": 0.02, "omega": 0.0}],
        "docked": True,
        "goals": 2,
        "gate_stops": 1,
        "gate_limited_s": 0.5,
        "codes": ["BLOCKED", "SUCCESS"],
        "time_s": 20.0,
    }
    summary = summarize([run, run | {"touches": [], "goals": 1}])
    assert (summary["touched"], summary["touched_driving"], summary["fastest_touch_m_s"]) == (1, 0, 0.02)
    assert (summary["docked"], summary["docked_by_the_first_goal"]) == (2, 1)
