"""What is drawn for a case follows from its seed alone; whatever is wrong is named before the first run."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from campaign_plans import CONFIG, FILES, campaign, values

from seater_common.geometry import Limits
from seater_common.params import ParameterError
from seater_eval.campaign.plan import Plan, Shard
from seater_eval.campaign.setup.campaign_file import campaign_from, load_campaign, only
from seater_eval.campaign.setup.cases import case_of_seed, draw_case
from seater_eval.campaign.setup.changes import drawn, merged
from seater_eval.campaign.setup.configuration import Configuration
from seater_eval.campaign.setup.told import _odometry, told_parameters
from seater_sim.chair.make import make_plant
from seater_sim.settings import FloorSettings, OdometrySettings, PlantSettings, WheelSettings, without_effects

LAG = {"simulator": {"plant": {"kinematic": {"lag_v": {"between": [0.1, 0.4]}}}}}


def configuration(**changes: Any) -> Configuration:
    made = campaign(only={"one": changes})
    return draw_case(FILES, made, 1, 0).configuration(FILES, made)


def test_drawn_numbers_lie_between_their_bounds_and_fill_them() -> None:
    rng = np.random.default_rng(3)
    found = [drawn({"a": {"b": {"between": [-1, 2.0]}}, "c": [1]}, rng, "x") for _ in range(300)]
    numbers = [value["a"]["b"] for value, _ in found]
    assert -1.0 <= min(numbers) < -0.9 and 1.9 < max(numbers) <= 2.0
    assert found[0] == ({"a": {"b": numbers[0]}, "c": [1]}, {"x/a/b": numbers[0]})


@pytest.mark.parametrize("bounds", [[1.0], [2.0, 1.0], "wide", [0.0, float("inf")], ["a", "b"]])
def test_wrong_bounds_are_named(bounds: Any) -> None:
    with pytest.raises(ParameterError, match=r"x/key: is .*between"):
        drawn({"key": {"between": bounds}}, np.random.default_rng(0), "x")


def test_changes_lie_over_the_file_and_lists_are_replaced() -> None:
    base = {"a": {"b": 1, "c": 2}, "d": [1, 2, 3]}
    assert merged(base, {"a": {"c": 5}, "d": [9]}) == {"a": {"b": 1, "c": 5}, "d": [9]}
    assert base == {"a": {"b": 1, "c": 2}, "d": [1, 2, 3]}


def test_a_case_follows_from_its_seed() -> None:
    made = campaign(plant={"slow": LAG, "quick": {}}, chair={"a": {}, "b": {}, "c": {}})
    cases = [draw_case(FILES, made, 5, index) for index in range(60)]
    assert cases[7] == draw_case(FILES, made, 5, 7) == case_of_seed(FILES, made, cases[7].seed, 7)
    assert {case.variants["chair"] for case in cases} == {"a", "b", "c"}
    slow = [case for case in cases if case.variants["plant"] == "slow"]
    assert 15 < len(slow) < 45
    assert len({case.numbers["simulator/plant/kinematic/lag_v"] for case in slow}) == len(slow)
    assert draw_case(FILES, made, 6, 7).seed != cases[7].seed


def test_what_one_axis_draws_does_not_depend_on_the_variants_of_another() -> None:
    lonely = campaign(chair={"a": {}}, plant={"slow": LAG})
    drawing = campaign(chair={"a": {"chair": {"width": {"between": [0.5, 0.6]}}}}, plant={"slow": LAG})
    one, other = draw_case(FILES, lonely, 1, 0).numbers, draw_case(FILES, drawing, 1, 0).numbers
    assert one["simulator/plant/kinematic/lag_v"] == other["simulator/plant/kinematic/lag_v"]


def test_variants_change_what_they_say_and_only_that() -> None:
    plain = configuration()
    narrow = configuration(chair={"width": 0.5}, simulated_chair={"camera": {"yaw": 0.02}})
    assert (narrow.chair.width, narrow.simulated_chair.width) == (0.5, 0.5)
    assert (narrow.chair.camera.yaw, narrow.simulated_chair.camera.yaw) == (0.0, 0.02)
    assert plain.chair.width == plain.simulated_chair.width == 0.65
    assert narrow.mount_values["yaw"] == 0.0  # perception is told the chair's file
    assert narrow.dock == plain.dock and narrow.parameters == plain.parameters


def test_the_controller_is_told_the_truth_or_its_defaults() -> None:
    c = configuration(simulator={"plant": {"kind": "kinematic", "kinematic": {"lag_v": 0.33, "command_delay": 0.21}}})
    before = c.parameters.control.prediction
    assert told_parameters(c.parameters, c.simulator, c.chair, "defaults", 1) == c.parameters
    told = told_parameters(c.parameters, c.simulator, c.chair, "truth", 1).control.prediction
    assert (told.command_delay, told.motor_lag) == (0.21, 0.33) != (before.command_delay, before.motor_lag)


def test_the_odometry_errors_that_are_told_are_those_of_the_simulated_encoders() -> None:
    """Constant slip and wheels that are off: a straight drive and a turn on the spot show the three errors."""
    wheels = WheelSettings(radius_error_left=0.02, radius_error_right=-0.01, track_error=0.03, ticks=0)
    floor = FloorSettings(0.05, 0.01, 0.0, patch_slip=0.0, compliance=0.0, downhill_turn=0.0, side_slip=0.0)
    chair = replace(without_effects(), wheels=wheels, floor=floor)
    told = _odometry(chair)

    def drive(v: float, omega: float) -> tuple[float, float, float, float]:
        plant, odometry = make_plant(
            PlantSettings("wheelchair", wheelchair=chair), OdometrySettings(), Limits(), np.zeros(3), 1
        )
        way = turn = 0.0
        for _ in range(200):
            plant.command(v, omega)
            plant.step(10_000_000)
            way, turn = way + plant.motion.way, turn + plant.motion.turn
        sample = odometry.update(way, turn, 2_000_000_000, plant.time_ns)
        return way, turn, 2.0 * sample.v, 2.0 * sample.omega

    for v, omega in ((0.3, 0.0), (0.2, 0.4)):
        way, turn, measured_way, measured_turn = drive(v, omega)
        expected = (1.0 + told["odometry_heading_scale"]) * turn + told["odometry_heading_drift"] * way
        assert measured_turn == pytest.approx(expected, abs=1e-6)
        cross = 0.25 * turn * wheels.track**2 * (1.0 + wheels.track_error) * told["odometry_heading_drift"]
        assert measured_way - cross == pytest.approx((1.0 + told["odometry_scale"]) * way, abs=1e-6)


def test_a_plant_is_drawn_from_its_ranges_and_the_variant_s_own_keys_win() -> None:
    variant = {"plant": "worn_chair", "simulator": {"camera": {"rate": 7.0}}}
    made = campaign(plant={"worn": variant})
    cases = [draw_case(FILES, made, 1, index) for index in range(5)]
    plants = [case.configuration(FILES, made).simulator for case in cases]
    low, high = FILES.contents["plants/worn_chair.yaml"]["wheelchair"]["motor"]["lag_v"]
    lags = [plant.plant.wheelchair.motor.lag_v for plant in plants]
    assert len(set(lags)) == 5 and all(low <= lag <= high for lag in lags)
    assert lags == [case.numbers["plant/wheelchair/motor/lag_v"] for case in cases]
    assert {plant.plant.kind for plant in plants} == {"wheelchair"} and {p.camera.rate for p in plants} == {7.0}
    assert cases[0].variants["plant/wheelchair/command/deadband_kind"] in ("jump", "offset")
    assert "plant/wheelchair/castors/start_angle" not in cases[0].numbers  # its range is one value


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"charm": {}}, "axes/axis/it/charm: unknown"),
        (3, "axes/axis/it: is 3"),
    ],
)
def test_a_wrong_campaign_file_is_refused_with_the_key(changes: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        campaign_from(values(axis={"it": changes}), "test.yaml")


def test_every_key_of_a_campaign_file_is_required_and_axes_too() -> None:
    whole = values()
    for key in ("longest", "start", "bars"):
        with pytest.raises(ParameterError, match=rf"test.yaml/{key}: is missing"):
            campaign_from({name: value for name, value in whole.items() if name != key}, "test.yaml")
    with pytest.raises(ParameterError, match="must name at least one axis"):
        campaign_from(whole | {"axes": {}}, "test.yaml")
    with pytest.raises(ParameterError, match="lowest must not be above"):
        campaign_from(whole | {"start": whole["start"] | {"x": [1.0, 0.0]}}, "test.yaml")


@pytest.mark.parametrize("path", sorted((CONFIG / "campaign").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_campaigns_of_the_project_fit_its_configuration(path: Path) -> None:
    made = load_campaign(path)
    Plan.make(CONFIG, path.stem, "defaults", 1, 10, Shard())
    for index in range(20):
        draw_case(FILES, made, 1, index)


def test_a_variant_that_does_not_fit_is_named_before_the_first_run(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    text = (CONFIG / "campaign" / "default.yaml").read_text()
    file.write_text(text[: text.index("axes:")] + "axes: {chair: {odd: {chair: {widht: 1.0, width: -1}}}}\n")
    with pytest.raises(ParameterError) as error:
        Plan.make(CONFIG, str(file), "defaults", 1, 10, Shard())
    for part in ("axes/chair/odd", "chair/widht: unknown key", "chair/width: is -1"):
        assert part in str(error.value)


def test_axes_that_are_not_named_stay_at_their_first_variant() -> None:
    made = only(load_campaign(CONFIG / "campaign" / "everything.yaml"), ["dock", "start"])
    assert {axis: len(variants) for axis, variants in made.axes.items() if len(variants) > 1} == {"dock": 7, "start": 3}
    assert list(made.axes["camera"]) == ["d455"]
    with pytest.raises(ParameterError, match="--axes: 'colour' is unknown; known are plant, chair, dock"):
        only(made, ["colour"])


def test_shards_share_the_cases_out_without_a_rest() -> None:
    def of(shard: str) -> list[int]:
        return [job.index for job in Plan.make(CONFIG, "default", "defaults", 1, 11, Shard.parse(shard)).jobs()]

    assert sorted(of("1/3") + of("2/3") + of("3/3")) == of("1/1") == list(range(11))
    for wrong in ("0/3", "4/3", "3", "a/b"):
        with pytest.raises(ParameterError, match="--shard"):
            Shard.parse(wrong)


def test_what_was_identified_needs_the_package_that_identifies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ParameterError, match=r"--told identified: needs seater_identify\.simulated"):
        Plan.make(CONFIG, "default", "identified", 1, 1, Shard())
