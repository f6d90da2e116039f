"""Random chairs from config/plants/."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from seater_common.params import ParameterError, as_mapping
from seater_sim.chair.plant_ranges import PlantRanges, load_plant_ranges
from seater_sim.settings import SimulatorSettings, WheelchairSettings, without_effects

PLANTS = Path(__file__).resolve().parents[4] / "config" / "plants"
NAMES = ["indoor_chair", "ramp", "small_robot", "worn_chair"]


def ranges_of(name: str) -> PlantRanges:
    return load_plant_ranges(PLANTS / f"{name}.yaml")


def flat(values: Any, prefix: str = "") -> dict[str, Any]:
    if not isinstance(values, dict):
        return {prefix: values}
    return {k: v for name, inner in values.items() for k, v in flat(inner, f"{prefix}/{name}").items()}


def test_every_file_is_known_here() -> None:
    assert sorted(path.stem for path in PLANTS.glob("*.yaml")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_draws_fill_their_ranges_and_stay_inside(name: str) -> None:
    ranges, rng = ranges_of(name), np.random.default_rng(1)
    draws = [flat(as_mapping(ranges.draw(rng))) for _ in range(200)]
    for key, allowed in flat(ranges.ranges["wheelchair"]).items():
        drawn = [draw[key] for draw in draws]
        if isinstance(allowed[0], str | bool):
            assert set(drawn) == set(allowed), key
        else:
            low, high = allowed
            # Of 200 uniform draws, the extremes miss the outer 5 % with a probability of 0.95^200 = 4e-5.
            margin = 0.05 * (high - low)
            assert low <= min(drawn) <= low + margin and high - margin <= max(drawn) <= high, key


def test_same_generator_same_draw_whatever_the_order_of_the_file() -> None:
    ranges = ranges_of("worn_chair")
    backwards = {
        part: dict(reversed(keys.items())) for part, keys in reversed(list(ranges.ranges["wheelchair"].items()))
    }
    other = PlantRanges({**ranges.ranges, "wheelchair": backwards})
    assert ranges.draw(np.random.default_rng(7)) == other.draw(np.random.default_rng(7))
    assert ranges.draw(np.random.default_rng(7)) != ranges.draw(np.random.default_rng(8))


def test_a_drawn_simulator_drives_the_chair_with_its_timing() -> None:
    ranges, settings = ranges_of("worn_chair"), SimulatorSettings()
    drawn = [ranges.draw_simulator(np.random.default_rng(seed), settings) for seed in range(30)]
    assert {d.plant.kind for d in drawn} == {"wheelchair"}
    assert drawn[3].plant.wheelchair == ranges.draw(np.random.default_rng(3))
    assert all(10.0 <= d.camera.rate <= 30.0 and 0.05 <= d.camera.latency <= 0.15 for d in drawn)
    assert {d.odometry.period for d in drawn} <= {round(0.01 * k, 9) for k in range(2, 11)}
    assert len({d.odometry.period for d in drawn}) > 4
    assert drawn[0].odometry.origin == settings.odometry.origin and drawn[0].camera.encoding == settings.camera.encoding


def test_the_default_chair_is_an_indoor_chair_with_every_effect_on() -> None:
    default, off = (flat(as_mapping(chair)) for chair in (WheelchairSettings(), without_effects()))
    for key, allowed in flat(ranges_of("indoor_chair").ranges["wheelchair"]).items():
        low, high = min(allowed), max(allowed)
        assert low <= default[key] <= high, key
        if not isinstance(low, str) and low < 0.0 < high:  # an error, to either side
            assert abs(default[key]) >= 0.25 * high, key
    # What is no effect: sizes, kinds, the time-out, a driver that is poor.
    same = {key for key in default if default[key] == off[key]}
    sizes = {"/castors/ahead", "/castors/spread", "/wheels/radius", "/wheels/track", "/floor/patch_length"}
    choices = {"/command/deadband_kind", "/command/timeout", "/odometry/yaw", "/odometry/zero_twist"}
    choices |= {"/odometry/arrival_jitter"}  # several nodes in lock-step repeat to the last bit only without it
    assert same == sizes | choices | {"/floor/patch_gap", "/floor/patch_one_sided"}


def test_chairs_contain_the_values_that_defeated_the_controller_before() -> None:
    both = [flat(ranges_of(name).ranges) for name in ("indoor_chair", "worn_chair")]
    hard = {
        "command/delay": (0.25,),
        "command/deadband_v": (0.02,),
        "command/deadband_omega": (0.05,),
        "motor/lag_v": (0.15, 0.3),
        "motor/lag_omega": (0.15, 0.3),
        "motor/weak_left": (0.0, 0.03),
        "motor/weak_right": (0.0, 0.03),
        "floor/slip_left": (0.0, 0.04),
        "floor/slip_right": (0.0, 0.04),
        "floor/patch_slip": (0.12,),
        "floor/slope": (0.0, 0.0349),
        "wheels/radius_error_left": (-0.015, 0.015),
        "wheels/radius_error_right": (-0.015, 0.015),
        "wheels/track_error": (-0.015, 0.015),
        "castors/push_omega": (0.1,),
        "castors/push_v": (0.02,),
    }
    for key, values in hard.items():
        lows, highs = zip(*(file[f"/wheelchair/{key}"] for file in both), strict=True)
        assert all(min(lows) <= value <= max(highs) for value in values), key
    assert all(file["/camera/rate"][0] <= 10.0 and file["/camera/latency"][1] >= 0.12 for file in both)


def put(keys: str, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(values: dict[str, Any]) -> None:
        *outer, last = keys.split("/")
        for name in outer:
            values = values[name]
        values[last] = value

    return change


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (put("wheelchair/motor/lag_v", [0.3, 0.1]), r"motor/lag_v: is \[0.3, 0.1\], must be \[low, high\]"),
        (put("wheelchair/motor/lag_v", 0.2), r"motor/lag_v: is 0.2, must be a range"),
        (put("wheelchair/motor/lag_v", [0.1, 9.0]), r"motor/lag_v: is 9.0, must be <= 2.0 \[s\]"),
        (put("wheelchair/motor/lagg", [0.1, 0.2]), r"motor/lagg: unknown key"),
        (put("wheelchair/command/deadband_kind", ["jump", "hop"]), r"deadband_kind: is 'hop', must be one of"),
        (put("wheelchair/wheels/ticks", [100, 200.5]), r"ticks: is 200.5, must be of type int"),
        (put("wheelchair/floor", {}), r"wheelchair/floor/slip_left: is missing"),
        (put("camera/rate", ["fast", 3]), r"camera/rate: is \['fast', 3\], must be \[low, high\]"),
    ],
)
def test_wrong_files_are_refused_by_file_and_key(
    tmp_path: Path, change: Callable[[dict[str, Any]], None], text: str
) -> None:
    values = yaml.safe_load((PLANTS / "indoor_chair.yaml").read_text())
    change(values)
    path = tmp_path / "my_chair.yaml"
    path.write_text(yaml.safe_dump(values))
    with pytest.raises(ParameterError, match=rf"my_chair\.yaml/.*{text}"):
        load_plant_ranges(path)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"cannot read .*nowhere\.yaml"):
        load_plant_ranges(tmp_path / "nowhere.yaml")


def test_a_fixed_value_is_drawn_as_it_is() -> None:
    ranges = ranges_of("small_robot")
    wheels = ranges.draw(np.random.default_rng(1)).wheels
    assert (wheels.radius, wheels.track, wheels.ticks) == (0.035, 0.23, 2578)
    assert dataclasses.is_dataclass(wheels)
