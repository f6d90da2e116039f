"""Whole runs on the independent chair, and what the controller is told."""

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from seater_common.geometry import Chair, Dock
from seater_eval.judge.campaign import bars, describe, run_rows, summarize
from seater_eval.judge.cases import Row, draw_start, rows
from seater_eval.judge.parts import load_files
from seater_eval.judge.plant.built import Built, draw_built
from seater_eval.judge.plant.camera import DockCamera
from seater_eval.judge.plant.chair import STEP, IndependentChair
from seater_eval.judge.plant.effects import Effects, Encoders, Pictures, changed, kinematic
from seater_eval.judge.plant.encoders import WheelOdometry
from seater_eval.judge.run import Job, run
from seater_eval.judge.told import odometry_errors, set_known, told_parameters
from seater_eval.judge.verdict import smallest_gap

CONFIG = Path(__file__).resolve().parents[3] / "config"


def job(name: str, seed: int, **values: str) -> Job:
    return Job(str(CONFIG), rows()[name][0], seed, **values)


def test_a_kinematic_chair_docks_and_the_same_seed_gives_the_same_bits() -> None:
    """By the sequence, in between by the class alone: what ran before does not matter."""
    values, log = run(job("kinematic", 3))
    of_class, log_of_class = run(job("kinematic", 3, driver="class"))
    again, same = run(job("kinematic", 3))
    assert values["docked"] and values["code"] == "SUCCESS" and not values["touched"]
    assert values["position_error_m"] < 0.006 and values["estimate_error_m"] < 0.02
    assert values["noticed_s"] is None and values["moved_after_fault_m"] is None  # without a fault
    assert np.array_equal(log.motion.poses, same.motion.poses) and np.array_equal(log.estimates, same.estimates)
    assert {key for key in values if values[key] != again[key]} <= {"wall_s"}
    assert of_class["docked"] and of_class["code"] == "" and of_class["position_error_m"] < 0.003
    assert np.diff(log_of_class.commands[:, 0]) == pytest.approx(0.05)


def test_a_creeping_class_is_given_time_to_stand() -> None:
    values, _ = run(job("no_deadband", 1, driver="class", told="delay_lag"))
    assert values["stands"] and values["docked"]


def test_images_arrive_late_and_odometry_begins_each_cycle() -> None:
    values, log = run(Job(str(CONFIG), Row("x", changed(kinematic(), "pictures", latency=0.3, rate=10.0)), 3))
    assert log.estimates[:, 5].min() >= 0.3 - 1e-9  # no estimate is younger than the latency
    assert set(np.diff(log.commands[:, 0]).round(3)) == {0.04, 0.06}  # odometry at 50 Hz begins periods of 50 ms
    assert sum(values["outcomes"].values()) == pytest.approx(10.0 * log.motion.times[-1], abs=5)


def test_starts_are_as_documented() -> None:
    chair, dock, rng = Chair(), Dock(), np.random.default_rng(2)
    camera = DockCamera(chair, dock, Pictures(), rng)
    for kind in ("front", "beside", "turned"):
        starts = np.array([draw_start(kind, chair, dock, camera, rng) for _ in range(40)])
        assert min(smallest_gap(starts[k : k + 1], chair, dock) for k in range(40)) >= 0.1
        seen = [bool(camera.seen(tuple(start))) for start in starts]
        turned = np.abs(starts[:, 2])
        if kind == "front":
            assert all(seen) and np.all(turned <= math.radians(60.0)) and starts[:, 0].max() <= -1.0
        elif kind == "beside":
            assert np.all((np.abs(starts[:, 1]) >= 1.0) & (np.abs(starts[:, 1]) <= 2.0))
        else:
            assert not any(seen) and np.mean(turned > math.radians(90.0)) > 0.6


def drifting(**values: object) -> tuple[Built, np.ndarray, float, float]:
    """A chair with constant errors drives a bend: its draw, (measured way, turn), true way and turn."""
    effects = changed(changed(Effects(), "floor", patch_slip=0.0, slope=0.0, castor_omega=0.0, castor_v=0.0), "drive")
    built = draw_built(effects, np.random.default_rng(5))
    chair = IndependentChair(effects, built, (0.0, 0.0, 0.0), np.random.default_rng(0))
    odometry = WheelOdometry(Encoders(tick=1e-7), 0.0, (0.0, 0.0, 0.0), np.random.default_rng(0))
    chair.command(0.0, 0.4, float(values.get("omega", 0.0)))
    way = turn = 0.0
    for k in range(800):
        odometry.look(k * STEP, chair.rolled)
        chair.step(k * STEP)
        way, turn = way + chair.v * STEP, turn + chair.omega * STEP
    odometry.look(800 * STEP, chair.rolled)
    return built, np.array([odometry._way, odometry._turn]), way, turn


@pytest.mark.parametrize("omega", [0.0, 0.3, -0.3])
def test_the_told_odometry_errors_are_those_of_the_chair(omega: float) -> None:
    built, measured, way, turn = drifting(omega=omega)
    told = odometry_errors(Effects(), built, True)
    assert measured[0] == pytest.approx((1.0 + told["odometry_scale"]) * way, rel=1e-3)
    expected = (1.0 + told["odometry_heading_scale"]) * turn + told["odometry_heading_drift"] * way
    assert measured[1] == pytest.approx(expected, abs=0.003)  # of 1.2 rad; to first order


def test_only_known_keys_are_told() -> None:
    @dataclass(frozen=True)
    class Group:
        motor_lag: float = 0.0

    assert set_known(Group(), {"motor_lag": 0.2, "gain_v": 0.9}) == Group(0.2)


def test_what_is_told() -> None:
    base, effects = load_files(str(CONFIG)).parameters, Effects()
    built = draw_built(effects, np.random.default_rng(1))
    assert told_parameters(base, "nothing", effects, built) is base
    some, everything = (told_parameters(base, told, effects, built) for told in ("delay_lag", "all"))
    assert some.control.prediction.command_delay == 0.25
    assert some.control.prediction.motor_lag == pytest.approx(built.lag_v, abs=1e-3)
    assert some.observer == base.observer
    assert everything.observer.scale_sd > base.observer.scale_sd
    with pytest.raises(ValueError, match="told: is 'much', must be one of nothing"):
        told_parameters(base, "much", effects, built)


def test_rows_alone_differ_from_the_kinematic_chair_in_their_effect_only() -> None:
    sets = rows()
    assert sets["deadband_omega"][0].effects == changed(kinematic(), "drive", deadband_omega=0.05)
    assert sets["deadband_omega_2x"][0].effects == changed(kinematic(), "drive", deadband_omega=0.1)
    assert sets["lag_2x"][0].effects.drive.lag == (0.3, 0.6)
    assert sets["issue"][0].effects == Effects()
    assert [row.effects.pictures.rate for row in sets["camera_rate"]] == [10.0, 5.0, 3.0]
    names = [row.name for row in sets["effects"]]
    assert len(names) == len(set(names)) and {"castors", "castors_2x", "zero_twist", "odometry_rate_5"} <= set(names)


def fake_run(**values: object) -> dict:
    numbers = (
        "position_error_m heading_error_deg smallest_gap_m reversals turn_changes time_s peak_acceleration_m_s2"
        " rms_acceleration_m_s2 peak_jerk_m_s3 rms_jerk_m_s3 peak_turning_acceleration_rad_s2 peak_turning_jerk_rad_s3"
        " estimate_error_m estimate_error_deg nees_mean noticed_s moved_after_fault_m"
    )
    return {
        **dict.fromkeys(numbers.split(), 1.0),
        "docked": True,
        "moved_m": 2.0,
        "text": "",
        "touched": False,
        "stands": True,
        "code": "SUCCESS",
    } | values


def test_a_false_success_is_counted_and_misses_its_bar() -> None:
    summary = summarize([fake_run(), fake_run(docked=False), fake_run(docked=False, touched=True, code="MARKER_LOST")])
    assert (summary["docked"], summary["touched"], summary["falsely_successful"]) == (1, 1, 1)
    assert summary["refused"] == 0 and summarize([fake_run(docked=False, moved_m=0.0)])["refused"] == 1
    data = {"seed": 1, "driver": "sequence", "told": "nothing", "rows": [{"name": "row", "summary": summary}]}
    assert [bar.met for bar in bars(data)] == [False, False, False]
    assert "1 of 3" in describe(data) and "SUCCESS 2, MARKER_LOST 1" in describe(data)


def test_equal_causes_are_counted_together() -> None:
    texts = ("no marker for 0.31 m and 2 s", "no marker for 0.4 m and 1.5 s", "too far")
    summary = summarize([fake_run(docked=False, code="MARKER_LOST", text=text) for text in texts])
    assert summary["failures"] == {"MARKER_LOST: no marker for # m and # s": 2, "MARKER_LOST: too far": 1}


def test_a_campaign_can_be_written_as_json() -> None:
    data = run_rows(CONFIG, rows()["issue"], 1, seed=2, workers=1)
    assert json.loads(json.dumps(data["rows"][0]["runs"][0]))["seed"] == data["rows"][0]["runs"][0]["seed"]


def test_nothing_is_shared_with_the_simulator() -> None:
    folder = Path(__file__).resolve().parents[1] / "src" / "seater_eval" / "judge"
    assert [
        path for path in folder.rglob("*.py") if "import" in path.read_text() and "from seater_sim" in path.read_text()
    ] == []
