"""One docking out of images: the same to the bit each time, whatever ran before; what goes wrong is in its row."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from campaign_plans import FEW_IMAGES, FILES, RATE, campaign, job

import seater_safety
from seater_common.geometry import Chair
from seater_common.params import ParameterError
from seater_eval.campaign.drive import docking
from seater_eval.campaign.drive.chain import Gate, Perception
from seater_eval.campaign.drive.comfort import comfort, sign_changes
from seater_eval.campaign.drive.job import CampaignJob, docking_row, prepare, run_case
from seater_eval.campaign.setup.cases import draw_case

SAFETY = {e["key"]: e["default"] for e in seater_safety.describe_parameters() if e["file"] == "safety"}


def started_at(work: CampaignJob) -> list[float]:
    """Where the chair of a case stands before its first step."""
    _, run = prepare(work, draw_case(work.files, work.campaign, 1, work.index))
    return run.simulator.truth.pose.tolist()


def test_a_case_docks_out_of_images_and_comes_out_the_same_again() -> None:
    plant = {"kinematic": {"simulator": {"plant": {"kinematic": {"lag_v": {"between": [0.05, 0.15]}}}}}}
    made = campaign(plant=plant, images=FEW_IMAGES)
    first, started = docking_row(replace(job(made), bound=True))
    assert 1.0 <= first.pop("time_ratio") < 2.5 and first.pop("minimum_time_s") <= first["arrival_time_s"]
    assert first["arrival_time_s"] <= first["docking_time_s"]
    assert first["docked"] and first["result"] == "SUCCESS" and first["contact"], first["text"]
    assert first["position_error_m"] < 0.005 and not first["touched"]
    # so many images per second of simulated time, of which those after the result are not drawn
    assert first["images"] == pytest.approx(RATE * first["docking_time_s"], abs=1.5)
    assert first["images_with_markers"] > 0.95 * first["images"]
    assert started_at(job(made)) == first["start"] != started_at(job(made, index=1))
    assert started is not None
    view = started[1].sequence._controller._areas.view  # what the node learns from camera_info
    assert np.array_equal(view.camera.K, started[0].camera.K)
    trace = started[1].trace
    _, again = prepare(job(made), draw_case(job(made).files, made, 1, 0))
    again.run(4.0, 0.0)
    assert len(again.trace.images) > 3.0 * RATE
    for begun, whole in ((again.trace.cycle_rows, trace.cycle_rows), (again.trace.image_rows, trace.image_rows)):
        assert np.array_equal(begun, whole[: len(begun)], equal_nan=True)
    assert len(trace.images) == first["images"]
    steps = np.diff(trace.cycles[:, 0])  # odometry comes every 20 ms, cycles are due every 50 ms
    assert np.mean(steps) == pytest.approx(0.05, abs=1e-3) and set(np.round(steps, 6)) == {0.04, 0.06}
    assert np.max(np.abs(trace.cycles[-1, 6:8])) < 0.002  # [m] the estimate, at the end


def test_what_the_gate_lets_through_is_what_moves_the_chair(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Gate, "pass_on", lambda self, now, v, omega: (0.0, 0.0))
    row = run_case(job(campaign()))
    assert row["result"] == "BLOCKED" and row["images_with_markers"] > 20
    assert row["acceleration_peak"] == 0.0 and row["position_error_m"] == math.dist(row["start"][:2], (0.0, 0.0))


def test_what_perception_does_not_find_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Perception, "detect", lambda self, image: ([], []))
    row = run_case(job(campaign()))
    assert row["result"] == "FAILED_TO_DETECT_DOCK" and row["at_rest"] and not row["docked"]
    assert row["images"] == 300 and row["images_with_markers"] == 0  # 10 s, then nobody looks at images any more


def test_a_rough_pose_comes_with_the_goal_of_a_chair_that_is_turned_away() -> None:
    start = {"x": [-2.0, -1.9], "heading": [90.0, 270.0], "mirror": True, "seen": False, "rough_pose": True}
    made = campaign(start={"away": {"start": start}})
    poses = []
    for index in range(20):
        c, run = prepare(job(made, index), draw_case(FILES, made, 1, index))
        pose, truth = run._rough_pose, run.simulator.truth.pose
        assert pose is not None and abs(abs(math.degrees(truth[2])) % 360.0 - 180.0) <= 90.0
        assert c.start.rough_position_sd == 0.2
        poses.append(pose)
    assert 0.1 < np.std(np.array(poses)[:, :2]) < 0.3 and 2.0 < math.degrees(np.std(np.array(poses)[:, 2])) < 9.0


def test_an_exception_in_the_middle_is_a_row_with_its_text(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(self: Any, image: Any) -> None:
        raise RuntimeError("the lens fell off")

    monkeypatch.setattr(docking.ImageDocking, "_on_image", fail)
    row = run_case(job(campaign()))
    assert (row["result"], row["docked"]) == ("CRASHED", False)
    assert "the lens fell off" in row["text"] and "docking.py" in row["text"]
    assert row["start"] and row["simulated_s"] > 0.0


def test_what_no_node_would_start_with_is_refused_with_the_key() -> None:
    row = run_case(job(campaign(safety={"none": {"safety": {"a_stop": -1.0}}})))
    assert (row["result"], row["docked"], "start" in row) == ("REFUSED", False, False)
    assert "safety/a_stop" in row["text"]


def test_a_start_that_does_not_exist_is_said() -> None:
    row = run_case(job(campaign(start={"away": {"start": {"x": [-1.5, -1.4], "heading": [179.0, 181.0]}}})))
    assert row["result"] == "NO_START" and "in view" in row["text"]


@pytest.mark.extensive  # the independent chair's wrong installations run by default
def test_a_wrongly_mounted_camera_ends_beside_the_dock() -> None:
    """The simulated chair's camera looks 2 degrees to the left of what the controller is told. One attempt."""
    turned = {"simulated_chair": {"camera": {"yaw": math.radians(2.0)}}, "controller": {"sequence": {"max_retries": 0}}}
    row = run_case(job(campaign(mount={"turned": turned}, images=FEW_IMAGES)))
    assert not row["docked"] and row["at_rest"]
    assert abs(row["heading_error_deg"] + 2.0) < 0.5 or row["result"] != "SUCCESS"


def test_the_gate_is_between_the_request_and_the_motors() -> None:
    gate = Gate(Chair(), SAFETY)
    gate.pass_on(0.0, 0.0, 0.0)
    v, omega = gate.pass_on(0.05, 5.0, 5.0)
    assert (v, omega) == pytest.approx((0.5 * 0.05, 1.0 * 0.05))  # a_max, alpha_max of the chair
    assert gate.limited == 1
    assert gate.pass_on(0.10, math.nan, 0.0)[0] == pytest.approx(0.0) and gate.refused == 1
    with pytest.raises(ParameterError, match="safety/user_timeout: is None"):
        Gate(Chair(), {key: value for key, value in SAFETY.items() if key != "user_timeout"})


def test_comfort_of_a_sine() -> None:
    """v = A sin(w t): peaks A w and A w^2, rms 1 / sqrt(2) of them; the window takes (w T)^2 / 24 = 0.2 % twice."""
    time = np.arange(0.0, 20.0, 0.01)
    amplitude, w = 0.3, 2.0 * math.pi * 0.35
    v = amplitude * np.sin(w * time)
    found = comfort(time, v, np.full_like(v, 0.5))
    assert found["acceleration_peak"] == pytest.approx(amplitude * w, rel=0.005)
    assert found["acceleration_rms"] == pytest.approx(amplitude * w / math.sqrt(2.0), rel=0.01)
    assert found["jerk_peak"] == pytest.approx(amplitude * w**2, rel=0.01)
    assert found["lateral_acceleration_peak"] == pytest.approx(0.5 * amplitude, rel=0.001)
    assert found["angular_acceleration_peak"] == 0.0
    assert found["reversals"] == 13  # every half period of 1.43 s


def test_standing_counts_neither_for_the_rms_nor_as_a_reversal() -> None:
    time = np.arange(0.0, 40.0, 0.01)
    v = np.where(time < 4.0, 0.2 * np.sin(2.0 * math.pi * time / 4.0), 0.0)
    short, long = (comfort(time[:n], v[:n], np.zeros(n)) for n in (500, 4000))
    assert short["acceleration_rms"] == pytest.approx(long["acceleration_rms"])
    assert sign_changes(np.array([0.1, 0.005, -0.005, 0.1, -0.1, 0.0, -0.1]), 0.01) == 1


def test_no_motion_at_all_has_no_comfort_to_speak_of() -> None:
    found = comfort(np.array([0.0]), np.zeros(1), np.zeros(1))
    assert set(found.values()) == {0.0}


def test_without_images_poses_have_the_errors_that_perception_would_make(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is rendered nor detected; what the mount is off by is in the poses, as in images."""
    monkeypatch.setattr(Perception, "__init__", lambda self, c: pytest.fail("perception was used"))
    row = run_case(replace(job(campaign()), images=False))
    assert row["docked"] and row["contact"] and 0.0 < row["position_error_m"] < 0.005, row["text"]
    assert "core_render_s" not in row  # and that the same comes out again: test_campaign_command.py, replayed
    off = campaign(mount={"turned": {"simulated_chair": {"camera": {"y": 0.008}}}})
    shifted = run_case(replace(job(off), images=False))
    assert abs(abs(shifted["lateral_error_m"] - row["lateral_error_m"]) - 0.008) < 0.004, shifted["text"]
