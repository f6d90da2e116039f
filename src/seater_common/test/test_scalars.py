"""Single values in the text of a YAML file."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from seater_common.files.scalars import with_values, written
from seater_common.params import ParameterError

DEFAULT_DOCK = Path(__file__).resolve().parents[3] / "config" / "docks" / "default.yaml"


def test_only_the_values_change() -> None:
    text = DEFAULT_DOCK.read_text()
    new = with_values(text, {("markers", 1, "position", 1): 0.361234, ("bay", "width"): 1.1}, "dock")
    changed = [(a, b) for a, b in zip(text.split("\n"), new.split("\n"), strict=True) if a != b]
    assert [b for _, b in changed] == [
        "  - {id: 1, size: 0.150, position: [0.90, 0.36123, 0.70], normal_yaw: 3.14159265358979}",
        "  width: 1.1                # [m] between the side walls",
    ]
    values = yaml.safe_load(new)
    assert values["markers"][1]["position"] == [0.9, 0.36123, 0.7] and values["bay"]["width"] == 1.1


def test_anchors_stay_and_comments_keep_their_column() -> None:
    text = "a: &s 0.5          # [m] half\nb: [1.0, *s]\n"
    assert with_values(text, {("b", 0): -2.0}, "f") == "a: &s 0.5          # [m] half\nb: [-2.0, *s]\n"
    assert with_values("a: &s 0.5          # half\n", {("a",): 12.25}, "f") == "a: &s 12.25        # half\n"


@pytest.mark.parametrize(
    ("text", "path", "problem"),
    [
        ("a: 1", ("b",), "f/b: is not written there"),
        ("a: [1]", ("a", 1), "f/a/1: is not written there"),
        ("a: {b: 1}", ("a",), "f/a: is not written there"),
        ("a: &s 0.1\nb: *s", ("b",), "f: values cannot be replaced one by one"),
        ("a: [", ("a",), "cannot edit f"),
    ],
)
def test_what_cannot_be_replaced_is_said(text: str, path: tuple[str | int, ...], problem: str) -> None:
    with pytest.raises(ParameterError, match=problem):
        with_values(text, {path: 2.0}, "f")


def test_numbers_are_written_for_yaml() -> None:
    assert [written(x) for x in (0.0, -0.0000012, 1e-5, 3.14159265, 2.0)] == ["0.0", "0.0", "0.00001", "3.14159", "2.0"]
