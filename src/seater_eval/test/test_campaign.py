import math
from pathlib import Path

import numpy as np
import pytest
from made_up_runs import synthetic_run

from seater_common.geometry import clearance
from seater_eval.control.campaign_cases import draw_cases
from seater_eval.control.campaign_report import describe_campaign, draw_campaign
from seater_eval.control.campaign_run import DockingRun, run_values
from seater_eval.control.campaign_summary import summarize_runs
from seater_eval.control.controller_campaign import CampaignJob, _told, _with_plant, run_campaign_job
from seater_eval.control.pose_noise import DockSensor, NoiseModel
from seater_eval.run.setup_files import Setup, load_setup
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.measurement import Hypothesis
from seater_sim.settings import KINEMATIC, WHEELCHAIR

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def setup() -> Setup:
    return load_setup(CONFIG)


@pytest.fixture(scope="module")
def sensor(setup: Setup) -> DockSensor:
    return DockSensor(setup.chair, setup.dock, setup.camera)


def test_markers_leave_the_view_to_the_side_and_behind(sensor: DockSensor) -> None:
    assert sensor.in_view((-2.0, 0.0, 0.0)) == [0, 1, 2]
    assert sensor.in_view((-2.0, 0.0, 0.7)) == [1]  # half the field of view is 45 degrees, marker 1 is to the left
    assert sensor.in_view((-2.0, 0.0, 1.2)) == []
    assert sensor.in_view((2.0, 0.0, math.pi)) == []  # seen from behind
    assert sensor.visible((-6.0, 0.0, 0.0)) == [] and sensor.in_view((-6.0, 0.0, 0.0)) == [0, 1, 2]  # too small


def error_of(hypothesis: Hypothesis, true: np.ndarray) -> np.ndarray:
    T = hypothesis.T_optical_dock
    turn = T[:3, :3] @ true[:3, :3].T
    rotation = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return np.concatenate([T[:3, 3] - true[:3, 3], rotation])


def test_noise_has_the_covariance_that_it_states(sensor: DockSensor) -> None:
    """Normalised error squared, mean 6; 400 draws leave a standard deviation of sqrt(12 / 400) = 0.17."""
    pose, rng = (-2.0, 0.3, -0.1), np.random.default_rng(2)
    true, squares = sensor.T_optical_dock(pose), []
    for _ in range(400):
        (hypothesis,) = sensor.measure(pose, rng)
        error = error_of(hypothesis, true)
        squares.append(error @ np.linalg.solve(hypothesis.covariance, error))
    assert np.mean(squares) == pytest.approx(6.0, abs=0.6)


def test_noise_grows_with_distance_and_is_that_of_corner_pixels(setup: Setup, sensor: DockSensor) -> None:
    near, far = (sensor.covariance(sensor.T_optical_dock((x, 0.0, 0.0)), [0, 1, 2]) for x in (-1.0, -3.0))
    assert np.all(np.diag(far) > np.diag(near))
    double = DockSensor(setup.chair, setup.dock, setup.camera, NoiseModel(corner_sigma=0.1, tilt_sigma=1e3))
    single = DockSensor(setup.chair, setup.dock, setup.camera, NoiseModel(corner_sigma=0.05, tilt_sigma=1e3))
    T = sensor.T_optical_dock((-2.0, 0.0, 0.0))
    np.testing.assert_allclose(double.covariance(T, [0]), 4.0 * single.covariance(T, [0]), rtol=1e-4)


def test_starts_are_as_stated_and_the_same_for_the_same_seed(setup: Setup, sensor: DockSensor) -> None:
    cases = draw_cases(setup, 60, 3, NoiseModel(), obstacles=True)
    assert cases[:20] == draw_cases(setup, 20, 3, NoiseModel(), obstacles=True)
    assert len({case.seed for case in cases}) == 60
    assert any(case.obstacles for case in cases)
    for case in cases:
        x, y, heading = case.start
        assert -4.0 <= x <= -1.0 and abs(y) <= 1.5 and abs(heading) <= math.radians(60.0)
        assert sensor.visible(case.start) and clearance(setup.chair, setup.dock.bay, case.start) >= 0.1


def test_one_run_docks(setup: Setup) -> None:
    (case,) = draw_cases(setup, 1, 4, NoiseModel(), obstacles=False)
    first = run_campaign_job(CampaignJob(str(CONFIG), case, "", NoiseModel()))
    assert first["docked"] and first["collisions"] == 0, first
    assert first["position_error_m"] < 0.01 and first["min_clearance_m"] > 0.0
    assert first["minimum_time_s"] <= first["docking_time_s"]
    assert first["certain_bound_s"] <= first["minimum_time_s"]
    data = {"summary": summarize_runs([first]), "runs": [first], "conditions": {"obstacles": "", "solver": ""}}
    assert "1 of 1 docked" in describe_campaign(data)


def test_the_plant_is_the_named_one_and_only_the_ideal_one_is_told(setup: Setup) -> None:
    assert setup.simulator.plant.kind == WHEELCHAIR and _with_plant(setup, "") == setup
    ideal = _with_plant(setup, KINEMATIC)
    assert ideal.simulator.plant.kind == KINEMATIC
    times = [(told.command_delay, told.motor_lag) for told in (_told(ideal), _told(setup))]
    assert times == [(0.04, 0.1), (0.15, 0.2)]


def test_a_docking_comes_out_the_same_whatever_the_controller_did_before(setup: Setup) -> None:
    """To the last bit: so results do not depend on how runs are shared out among workers."""
    first, second = draw_cases(setup, 2, 1, NoiseModel(), False)
    controller = DockingController(setup.chair, setup.dock, setup.parameters.control, deterministic=True)
    controller.warm_up()
    paths = [DockingRun(setup, case, controller).run(longest=3.0).poses for case in (first, second, first)]
    assert np.array_equal(paths[0], paths[2]) and not np.array_equal(paths[0], paths[1])


def test_a_chair_that_leaves_limits_and_view_is_caught(setup: Setup) -> None:
    """The watch is fed by hand: too fast a request, a jump, and a chair that looks away."""
    (case,) = draw_cases(setup, 1, 4, NoiseModel(), obstacles=False)
    controller = DockingController(setup.chair, setup.dock, setup.parameters.control, deterministic=True)
    run = DockingRun(setup, case, controller)
    run._request(0.02, 0.0)
    assert run.watch.excess_request <= 0.0
    run._request(0.02, 0.2)  # 0.2 rad/s within a cycle
    assert run.watch.excess_request == pytest.approx(0.2 - setup.chair.limits.alpha_max * run._period)
    run._request(0.0, 0.0)  # standing may always be asked for
    run._request(math.nan, 0.0)
    assert run.watch.not_finite == 1
    for _ in range(400):
        run.simulator.command(0.0, 0.8)
        run._observe(run.simulator.step())
    assert run.watch.out_of_view > 0.5
    for _ in range(100):
        run.simulator.command(0.0, 0.0)
        run.simulator.step()
    trajectory = run.run(longest=0.05)
    assert run_values(run, trajectory, case)["limits_violated"]


def test_figure_of_the_campaign(tmp_path: Path, setup: Setup) -> None:
    runs = [synthetic_run(), synthetic_run(docked=False, docking_time_s=None, minimum_time_s=None)]
    data = {"summary": summarize_runs(runs), "runs": runs, "conditions": {"obstacles": "none", "solver": "x"}}
    draw_campaign(data, setup.dock, setup.chair, tmp_path / "c.png")
    assert (tmp_path / "c.png").stat().st_size > 10_000
    assert "1 of 2 docked" in describe_campaign(data)
