"""Speeds to voltages and back: never beyond the table, neutral for whatever is unclear, and no table that is none."""

import io
import math
import runpy
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from seater_base.deflection.fit import FitError, Pair, as_yaml, fit, read_pairs
from seater_base.deflection.inverse import Axis, Deflections
from seater_base.deflection.table import AxisTable, DeflectionTable
from seater_common.params import ParameterError, load, read_yaml

FILE = Path(__file__).resolve().parents[3] / "config" / "deflection.yaml"
TABLE = AxisTable()


def random_table(random: np.random.Generator) -> AxisTable:
    """Curved, with a deadband, another one on each side; one in two falls."""
    low, high = np.sort(random.uniform(2.2, 2.8, 2))
    left, right = np.sort(random.uniform(1.0, 2.1, 4)), np.sort(random.uniform(2.9, 4.0, 5))
    volts = np.concatenate([left, [low, high], right])
    speeds = np.concatenate(
        [-np.sort(random.uniform(0.02, 0.6, 4))[::-1], [0, 0], np.sort(random.uniform(0.02, 0.6, 5))]
    )
    sign = random.choice([-1.0, 1.0])
    neutral = float(random.uniform(low, high))
    return AxisTable(neutral, 0.9, 4.1, tuple(volts.tolist()), tuple((sign * speeds).tolist()))


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(DeflectionTable, read_yaml(FILE), "deflection") == DeflectionTable()


def test_the_inverse_gives_the_speed_that_was_asked_for() -> None:
    """1000 random curves, judged by NumPy's own interpolation of the measured points."""
    random = np.random.default_rng(5)
    for _ in range(1000):
        table = random_table(random)
        axis = Axis(table)
        for speed in random.uniform(min(table.speeds), max(table.speeds), 5):
            assert np.interp(axis.volts(speed), table.volts, table.speeds) == pytest.approx(speed, abs=1e-9)
        assert axis.volts(0.0) == axis.volts(-0.0) == table.neutral


@pytest.mark.parametrize("asked", [0.5, 0.51, 7.0, 1e300])
def test_nothing_beyond_the_table(asked: float) -> None:
    assert Axis(TABLE).volts(asked) == 3.6 and Axis(TABLE).volts(-asked) == 1.4


@pytest.mark.parametrize("asked", [math.nan, math.inf, -math.inf])
def test_what_is_unclear_is_neutral_in_both_axes(asked: float) -> None:
    both = Deflections(DeflectionTable())
    assert both.volts(asked, 0.3) == both.volts(0.3, asked) == both.neutral == (2.5, 2.5)


def test_the_smallest_speed_leaves_the_deadband_and_a_falling_curve_turns_the_sign() -> None:
    assert Axis(TABLE).volts(1e-6) == pytest.approx(2.7, abs=1e-4)
    falling = Axis(replace(TABLE, speeds=tuple(reversed(TABLE.speeds))))
    assert falling.volts(1e-6) == pytest.approx(2.3, abs=1e-4) and falling.volts(0.3) == 1.8


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (
            {"speeds": (-0.5, -0.3, -0.08, 0.0, 0.0, 0.0, 0.3, 0.08, 0.5)},
            "not monotonic: the speed turns back from 0.3",
        ),
        ({"speeds": (-0.5, -0.3, -0.08, 0.0, 0.0, 0.0, 0.08, 0.5, 0.5)}, "does not change from 0.5 at 3.2 V"),
        ({"speeds": (-0.5, -0.3, 0.0, -0.08, 0.0, 0.0, 0.08, 0.3, 0.5)}, "not monotonic"),
        ({"speeds": (-0.5, -0.3, -0.08, 0.0, 0.0, 0.0, 0.08, 0.3)}, "belong together"),
        ({"speeds": (0.5, 0.3, 0.08, 0.0, 0.0, 0.0, 0.08, 0.3, 0.5)}, "one way only"),
        ({"volts": (1.4, 1.8, 1.8, 2.3, 2.5, 2.7, 2.8, 3.2, 3.6)}, "do not rise"),
        ({"lowest": 1.5}, "between lowest and highest"),
        ({"neutral": 2.75}, "stands from 2.3 to 2.7 V"),
        ({"volts": (), "speeds": ()}, "between lowest and highest"),
        ({"volts": (1.4, 3.6), "speeds": (-0.5, 0.5)}, "stands nowhere"),
    ],
)
def test_what_is_no_table(change: dict, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        replace(TABLE, **change)


def test_a_wrong_file_names_the_axis() -> None:
    values = read_yaml(FILE)
    values["turn"]["speeds"][0] = math.nan
    values["drive"]["speeds"][1] = 0.4
    with pytest.raises(ParameterError, match=r"(?s)drive: not monotonic.*turn/speeds\[0\]: is nan"):
        load(DeflectionTable, values, "deflection")


def pairs_of(table: AxisTable, random: np.random.Generator, sd: float = 0.003) -> list[Pair]:
    """Three repeats of 25 levels, with noise."""
    levels = [*np.linspace(1.0, 4.0, 25), table.neutral]
    return [("drive", v, float(np.interp(v, table.volts, table.speeds)) + random.normal(0.0, sd)) for v in levels * 3]


def test_a_fitted_table_drives_what_is_asked_for() -> None:
    """At speeds between the measured ones: within 20 mm/s, for curves as joysticks have."""
    random, worst = np.random.default_rng(7), 0.0
    for _ in range(100):
        band, power = random.uniform(0.05, 0.3), random.uniform(1.0, 2.0)
        volts = np.linspace(1.0, 4.0, 61)
        beyond = np.maximum(np.abs(volts - 2.5) - band, 0.0)
        truth = replace(
            TABLE, lowest=1.0, highest=4.0, volts=tuple(volts), speeds=tuple(np.sign(volts - 2.5) * 0.8 * beyond**power)
        )
        axis = Axis(fit("drive", pairs_of(truth, random), 2.5))
        for speed in random.uniform(-0.5, 0.5, 20):
            worst = max(worst, abs(float(np.interp(axis.volts(speed), truth.volts, truth.speeds)) - speed))
    assert worst < 0.02, worst  # 0.016 measured: noise of 3 mm/s, and the edge of the deadband between two levels


def test_saturated_ends_are_left_out() -> None:
    pairs = [("drive", v, max(-0.4, min(0.4, v - 2.5))) for v in np.arange(1.5, 3.6, 0.1)]
    table = fit("drive", pairs, 2.5)
    assert table.speeds[0] == -0.4 and table.speeds[-1] == 0.4
    assert (table.lowest, table.highest) == pytest.approx((2.1, 2.9), abs=1e-3)


@pytest.mark.parametrize(
    ("pairs", "problem"),
    [
        ([("drive", 2.5, 0.0), ("drive", 2.9, 0.2)], "2 voltages, 5 at least"),
        (
            [("drive", v, s) for v, s in zip((1, 2, 2.5, 3, 3.5, 4), (-0.4, -0.2, 0, 0.3, 0.15, 0.5), strict=True)],
            "not mono",
        ),
        ([("drive", v, v - 2.5) for v in (1.5, 2, 2.5, 3, 3.5)] + [("drive", 3.0, 0.1)], "at 3.00 V: measure anew"),
        (
            [("drive", v, v - 2.0) for v in (1.5, 1.8, 2.0, 2.5, 3, 3.5)],
            "neutral is 2.5 V, but the chair stands from 2.0",
        ),
    ],
)
def test_what_is_refused(pairs: list[Pair], problem: str) -> None:
    with pytest.raises(FitError, match=problem):
        fit("drive", pairs, 2.5)


def test_the_written_file_is_read_as_it_was_fitted(tmp_path: Path) -> None:
    table = fit("drive", pairs_of(TABLE, np.random.default_rng(1)), 2.5)
    text = as_yaml({"drive": table, "turn": TABLE}, "Measured: here")
    assert load(DeflectionTable, yaml.safe_load(text), "x") == DeflectionTable(table, TABLE)


@pytest.mark.parametrize("line", ["drive,2.5", "drive,nan,0.1", "lift,2.5,0.1", "drive,2.5,inf", "drive,x,1"])
def test_pairs_that_are_none_are_named_by_their_line(tmp_path: Path, line: str) -> None:
    file = tmp_path / "pairs.csv"
    file.write_text(f"axis,volts,speed\ndrive,2.5,0.0\n{line}\n")
    with pytest.raises(FitError, match=r"pairs.csv, line 3"):
        read_pairs(file)
    file.write_text("axis,volts,speed\nturn,2.5,-0.25\n")
    assert read_pairs(file) == [("turn", 2.5, -0.25)]


def test_pairs_of_a_spreadsheet_that_writes_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    file = tmp_path / "pairs.csv"
    file.write_bytes("\ufeffaxis;volts;speed\r\nturn;2,5;-0,25\r\n".encode())
    assert read_pairs(file) == [("turn", 2.5, -0.25)]


def test_other_columns_are_named(tmp_path: Path) -> None:
    file = tmp_path / "pairs.csv"
    file.write_text("axis,voltage,speed\nturn,2.5,-0.25\n")
    with pytest.raises(FitError, match=r"line 1: must be axis,volts,speed, is 'axis,voltage,speed'"):
        read_pairs(file)


def test_where_nobody_can_answer_nothing_drives(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As behind a pipe: the question of the lifted wheels is not answered with yes."""
    program = Path(__file__).resolve().parents[1] / "nodes" / "deflection_table"
    monkeypatch.setattr(sys, "argv", [str(program), "--drive", "--settings", str(FILE.parent / "base.yaml")])
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with pytest.raises(SystemExit, match="1"):
        runpy.run_path(str(program), run_name="__main__")
    assert "deflection_table: not driven" in capsys.readouterr().err
