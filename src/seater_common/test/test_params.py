import math
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, as_mapping, load, load_file, param


@dataclass(frozen=True)
class Inner:
    gain: float = param(1.0, "1/s", "a gain", low=0.0, high=10.0)


@dataclass(frozen=True)
class Outer:
    mode: str = param("fast", "", "how", choices=("fast", "calm"))
    count: int = param(3, "", "how many", low=1)
    inner: Inner = field(default_factory=Inner)
    weights: list[float] = param([1.0, 2.0], "", "weights", length=2, low=0.0)


GOOD = {"mode": "calm", "count": 2, "inner": {"gain": 3}, "weights": [1, 0.5]}


def test_load_gives_what_was_written() -> None:
    outer = load(Outer, GOOD, "outer")
    assert outer == Outer("calm", 2, Inner(3.0), [1.0, 0.5])


@pytest.mark.parametrize("cls", [Outer, Chair, Dock])
def test_defaults_are_loadable(cls: type) -> None:
    assert load(cls, as_mapping(cls()), "x") == cls()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mode": "slow"}, ["outer/mode", "slow", "fast, calm"]),
        ({"count": 0}, ["outer/count", "0", ">= 1"]),
        ({"count": 1.5}, ["outer/count", "1.5", "int"]),
        ({"count": True}, ["outer/count", "True", "int"]),
        ({"inner": {"gain": math.nan}}, ["outer/inner/gain", "nan", "finite"]),
        ({"inner": {"gain": 11}}, ["outer/inner/gain", "11", "<= 10", "1/s"]),
        ({"inner": {}}, ["outer/inner/gain", "missing", "a gain"]),
        ({"inner": 4}, ["outer/inner", "4", "mapping"]),
        ({"weights": [1]}, ["outer/weights", "1 entries", "2"]),
        ({"weights": [1, -1]}, ["outer/weights[1]", "-1", ">= 0"]),
        ({"mood": 1}, ["outer/mood", "unknown"]),
    ],
)
def test_a_wrong_value_is_named_in_full(change: dict, words: list[str]) -> None:
    with pytest.raises(ParameterError) as caught:
        load(Outer, {**GOOD, **change}, "outer")
    for word in words:
        assert word in str(caught.value)


def test_all_problems_are_reported_at_once() -> None:
    with pytest.raises(ParameterError) as caught:
        load(Outer, {**GOOD, "mode": "slow", "count": 0}, "outer")
    assert "outer/mode" in str(caught.value) and "outer/count" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\x9c\xff\x00", "is no text"),
        (b"a: b: c", "line 1, column 5: mapping values are not allowed here"),
        (b"markers:\n  - id: 1\n    si", "line 3, column 7: could not find expected ':'"),
        (b"a: \x01", "special characters are not allowed"),
        (None, "no such file or directory"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_line_with_its_name_and_why(
    tmp_path: Path, content: bytes | None, words: str
) -> None:
    path = tmp_path / "chair.yaml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ParameterError) as caught:
        load_file(Chair, path)
    text = str(caught.value)
    assert text.startswith(f"cannot read {path}: ") and words in text and "\n" not in text
    assert text.count(str(path)) == 1 and "Errno" not in text


def test_a_missing_key_is_explained_by_what_is_known_of_it() -> None:
    with pytest.raises(ParameterError) as caught:
        load(Chair, {}, "chair")
    assert "chair/width: is missing (" in str(caught.value)
    assert "( " not in str(caught.value) and "[]" not in str(caught.value) and "()" not in str(caught.value)


def test_same_marker_twice_is_refused() -> None:
    values = as_mapping(Dock())
    values["markers"][1]["id"] = 0
    with pytest.raises(ParameterError, match=r"dock: markers: ids \[0, 0, 2\]"):
        load(Dock, values, "dock")
