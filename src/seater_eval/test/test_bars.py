import json
import math

import pytest

from seater_eval.report.bars import AT_LEAST, Bar, all_met, bars_table, conclude, write_results
from seater_eval.report.statistics import spread
from seater_eval.report.tables import text_table


@pytest.mark.parametrize(
    ("value", "sense", "met"),
    [
        (0.9, "at most", True),
        (1.0, "at most", True),
        (1.1, "at most", False),
        (0.9, "at least", False),
        (1.0, "at least", True),
        (1.1, "at least", True),
        (None, "at most", False),
        (None, "at least", False),
        (math.nan, "at most", False),
        (-math.inf, "at most", False),
        (math.inf, "at least", False),
    ],
)
def test_a_bar_is_met_on_its_side_of_the_limit_and_never_without_a_number(value, sense, met) -> None:
    bar = Bar("b", value, 1.0, sense=sense)
    assert bar.met is met
    assert bar.as_mapping()["met"] is met


def test_unknown_sense_is_refused() -> None:
    with pytest.raises(ValueError, match="'about'"):
        Bar("b", 1.0, 1.0, sense="about")


def test_nothing_measured_is_not_met() -> None:
    assert not all_met([])
    assert all_met([Bar("b", 0.0, 1.0)])
    assert not all_met([Bar("b", 0.0, 1.0), Bar("c", 2.0, 1.0)])


def test_file_table_and_exit_code(tmp_path, capsys) -> None:
    good, bad = Bar("error", 0.5, 1.0, "mm"), Bar("ratio", None, 15.0, "", AT_LEAST, "not available: rti")
    assert conclude(tmp_path, "thing", {"x": 1}, [good]) == 0
    assert conclude(tmp_path, "thing", {"x": 1}, [good, bad]) == 1
    content = json.loads((tmp_path / "thing.json").read_text())
    assert content["x"] == 1
    assert content["bars"][0] == {
        "name": "error",
        "value": 0.5,
        "limit": 1.0,
        "met": True,
        "sense": "at most",
        "unit": "mm",
    }
    assert content["bars"][1]["value"] is None and content["bars"][1]["met"] is False
    text = capsys.readouterr().out
    (missed,) = (line for line in text.splitlines() if line.split()[:1] == ["ratio"])
    assert "0.5 mm" in text and "not measured" in missed and "NO" in missed and "not available: rti" in missed


def test_json_holds_no_nan_and_takes_arrays(tmp_path) -> None:
    import numpy as np

    path = write_results(tmp_path, "c", {"a": np.array([1.0, math.nan]), "b": np.float64(2.0), "c": (1, math.inf)}, [])
    assert json.loads(path.read_text()) == {"command": "c", "bars": [], "a": [1.0, None], "b": 2.0, "c": [1, None]}
    with pytest.raises(ValueError, match="bars"):
        write_results(tmp_path, "c", {"bars": 1}, [])


def test_spread() -> None:
    assert spread(range(101)) == {"median": 50.0, "p95": 95.0, "p99": 99.0, "max": 100.0}
    assert spread([]) == {"median": None, "p95": None, "p99": None, "max": None}
    assert spread([None, 3.0, math.nan])["median"] == 3.0


def test_columns_line_up() -> None:
    lines = text_table(["name", "x"], [["a", "1"], ["longer", "22"]]).splitlines()
    assert len({len(line) for line in lines}) == 1
    assert bars_table([Bar("b", 1.0, 1.0)]).count("\n") == 2
