"""What a joystick asks for: neutral whenever something is unclear, and never more than its settings."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from seater_common.params import ParameterError, load, read_yaml
from seater_controls.joystick.stick import Stick, Wish
from seater_controls.settings import AxisSettings, JoystickSettings

SETTINGS = JoystickSettings()
CONFIG = Path(__file__).resolve().parents[3] / "config"
CENTRE = {"ABS_Y": 128, "ABS_X": 128}


def plugged(
    settings: JoystickSettings = SETTINGS, raw: dict[str, int] = CENTRE, pressed: set[str] = frozenset()
) -> Stick:
    made = Stick(settings)
    made.plugged(raw, set(pressed), 0.0)
    return made


def driving(settings: JoystickSettings = SETTINGS) -> Stick:
    """With the dead-man's button pressed at neutral."""
    made = plugged(settings)
    made.event("BTN_TRIGGER", 1, 0.1)
    return made


def velocity(wish: Wish) -> tuple[float, float]:
    return wish.v, wish.omega


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(JoystickSettings, read_yaml(CONFIG / "joystick.yaml"), "joystick") == SETTINGS


@pytest.mark.parametrize(
    ("code", "value", "asked"),
    [
        ("ABS_Y", 0, (0.4, 0.0)),
        ("ABS_Y", 255, (-0.25, 0.0)),
        ("ABS_X", 0, (0.0, 0.6)),
        ("ABS_X", 255, (0.0, -0.6)),
        ("ABS_Y", 64, (0.4 * 4.0 / 9.0, 0.0)),  # half of the way, 0.1 of it deadband
        ("ABS_Y", 116, (0.0, 0.0)),
        ("ABS_Y", -10, (0.4, 0.0)),  # some beyond its end
    ],
)
def test_the_way_of_the_stick(code: str, value: int, asked: tuple[float, float]) -> None:
    made = driving()
    made.event(code, value, 0.2)
    assert velocity(made.wish(0.3)) == pytest.approx(asked)


def test_without_the_dead_mans_button_nothing_drives() -> None:
    made = driving()
    made.event("ABS_Y", 0, 0.2)
    made.event("BTN_TRIGGER", 0, 0.3)
    assert made.wish(0.3) == Wish(0.0, 0.0, False, "the dead-man's button is up")


def test_pressing_the_dead_mans_button_sets_nothing_moving() -> None:
    made = plugged()
    made.event("ABS_Y", 0, 0.1)
    made.event("BTN_TRIGGER", 1, 0.2)
    assert velocity(made.wish(0.3)) == (0.0, 0.0) and "neutral" in made.wish(0.3).why
    made.event("ABS_Y", 120, 0.4)
    made.event("ABS_Y", 0, 0.5)
    assert made.wish(0.6).v == 0.4


def test_a_joystick_that_is_held_when_it_is_plugged_in_drives_nothing() -> None:
    made = plugged(raw={"ABS_Y": 0, "ABS_X": 128}, pressed={"BTN_TRIGGER", "BTN_THUMB"})
    assert velocity(made.wish(0.1)) == (0.0, 0.0) and not made.wish(0.1).hold
    made.event("BTN_THUMB", 0, 0.2)
    made.event("BTN_THUMB", 1, 0.3)
    assert made.wish(0.3).hold


def test_unplugged_is_let_go_and_plugged_in_again_too() -> None:
    made = driving()
    made.event("ABS_Y", 0, 0.2)
    made.event("BTN_THUMB", 1, 0.2)
    assert made.wish(0.3).v == 0.4 and made.wish(0.3).hold
    made.unplugged("gone")
    assert made.wish(0.4) == Wish(0.0, 0.0, False, "gone")
    made.plugged({"ABS_Y": 0, "ABS_X": 128}, {"BTN_TRIGGER", "BTN_THUMB"}, 1.0)
    assert velocity(made.wish(1.1)) == (0.0, 0.0) and not made.wish(1.1).hold


@pytest.mark.parametrize("value", [-20, 275, 10**9, -(10**9)])
def test_a_number_beyond_its_range_is_let_go_until_neutral(value: int) -> None:
    made = driving()
    made.event("BTN_THUMB", 1, 0.2)
    made.event("ABS_Y", value, 0.3)
    assert velocity(made.wish(0.3)) == (0.0, 0.0) and not made.wish(0.3).hold and "calibrate" in made.wish(0.3).why
    made.event("ABS_Y", 0, 0.4)
    assert velocity(made.wish(0.4)) == (0.0, 0.0)
    made.event("ABS_Y", 128, 0.5)
    made.event("ABS_Y", 0, 0.6)
    assert made.wish(0.6).v == 0.4


def test_silence_is_let_go_where_the_stick_is_one_that_speaks() -> None:
    made = driving(replace(SETTINGS, silence=0.5))
    made.event("ABS_Y", 0, 0.2)
    assert made.wish(0.65).v == 0.4
    assert made.wish(0.75) == Wish(0.0, 0.0, False, "silent")
    made.event("ABS_Y", 1, 0.8)
    assert velocity(made.wish(0.8)) == (0.0, 0.0), "it was not at neutral since"
    assert driving().wish(1e6).why == "", "one that speaks of changes only"


def test_without_a_dead_mans_button_the_stick_alone_drives() -> None:
    made = plugged(replace(SETTINGS, dead_man=""))
    made.event("ABS_X", 0, 0.1)
    assert made.wish(0.2).omega == 0.6


def test_no_state_is_let_go() -> None:
    assert "no joystick" in Stick(SETTINGS).wish(0.0).why
    assert "ABS_X is not known" in plugged(raw={"ABS_Y": 128}).wish(0.0).why


def test_whatever_comes_in_whatever_order() -> None:
    """20 000 random events: finite, within the limits, and nothing without the dead-man's button."""
    random = np.random.default_rng(11)
    for seed in range(100):
        made, now, down = Stick(replace(SETTINGS, silence=float(random.choice([0.0, 0.3])))), 0.0, False
        for _ in range(200):
            now += random.exponential(0.05)
            kind = random.integers(0, 12)
            if kind == 0:
                pressed = {name for name in ("BTN_TRIGGER", "BTN_THUMB") if random.random() < 0.5}
                made.plugged({code: int(random.integers(0, 256)) for code in CENTRE}, pressed, now)
                down = "BTN_TRIGGER" in pressed
            elif kind == 1:
                made.unplugged("gone")
                down = False
            elif kind < 6:
                down = bool(random.random() < 0.8)
                made.event("BTN_TRIGGER", int(down), now)
            elif kind < 7:
                made.event("BTN_THUMB", int(random.random() < 0.5), now)
            else:
                wide = random.random() < 0.05
                value = int(random.integers(-(2**31), 2**31)) if wide else int(random.choice([0, 64, 128, 200, 255]))
                made.event(str(random.choice(["ABS_X", "ABS_Y"])), value, now)
            wish = made.wish(now)
            assert math.isfinite(wish.v) and -0.25 <= wish.v <= 0.4 and abs(wish.omega) <= 0.6, seed
            assert down or velocity(wish) == (0.0, 0.0), seed


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"drive": {"code": "ABS_Y", "negative": 255, "centre": 255, "positive": 0}}, "centre 255 is not between"),
        ({"hold": "BTN_TRIGGER"}, "the same axis or button"),
        ({"deadband": 0.0}, "deadband: is 0.0"),
        ({"v_forward": math.inf}, "must be finite"),
    ],
)
def test_wrong_settings_are_named(change: dict, problem: str) -> None:
    with pytest.raises(ParameterError, match=problem):
        load(JoystickSettings, {**read_yaml(CONFIG / "joystick.yaml"), **change}, "joystick")


def test_an_axis_that_is_not_in_the_middle() -> None:
    axis = AxisSettings("ABS_Y", negative=-100, centre=0, positive=1000)
    made = Stick(replace(SETTINGS, drive=axis, dead_man=""))
    made.plugged({"ABS_Y": 0, "ABS_X": 128}, set(), 0.0)
    made.event("ABS_Y", 1000, 0.1)
    assert made.wish(0.1).v == 0.4
    made.event("ABS_Y", -100, 0.2)
    assert made.wish(0.2).v == -0.25
