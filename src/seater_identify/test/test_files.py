"""Copies of the configuration files keep everything but the identified values."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from seater_common.geometry import Chair
from seater_common.params import ParameterError, load_file
from seater_identify.report.files import edited, write_copy
from seater_identify.settings import IdentifySettings

CONFIG = Path(__file__).resolve().parents[3] / "config"


def test_only_the_values_change() -> None:
    text = (CONFIG / "controller.yaml").read_text()
    new = edited(text, {"control/prediction/command_delay": 0.18321, "observer/scale_sd": 0.0035}, "controller.yaml")
    changed = [(a, b) for a, b in zip(text.split("\n"), new.split("\n"), strict=True) if a != b]
    assert len(changed) == 2
    assert all(a.partition("#")[2] == b.partition("#")[2] and a.index("#") == b.index("#") for a, b in changed)
    values = yaml.safe_load(new)
    assert values["control"]["prediction"]["command_delay"] == 0.1832
    assert values["observer"]["scale_sd"] == 0.0035


def test_a_key_of_the_same_name_elsewhere_stays() -> None:
    text = "a:\n  x: 1.0  # one\nb:\n  x: 2.0\n"
    assert edited(text, {"b/x": 3.0}, "f") == "a:\n  x: 1.0  # one\nb:\n  x: 3.0\n"


def test_tiny_values_stay_numbers() -> None:
    """YAML 1.1 reads 1e-05 as a text."""
    assert yaml.safe_load(edited("x: 1.0\n", {"x": 1e-5}, "f")) == {"x": 1e-5}
    assert yaml.safe_load(edited("x: 1.0\n", {"x": 1.25e-5}, "f")) == {"x": 1.25e-5}


def test_missing_keys_are_all_named() -> None:
    with pytest.raises(ParameterError, match=r"(?s)f/a/y: is not written there.*f/c: is not written there"):
        edited("a:\n  x: 1.0\n", {"a/y": 1.0, "c": 2.0}, "f")


def test_the_first_line_says_where_the_values_come_from(tmp_path: Path) -> None:
    source, copy = tmp_path / "a.yaml", tmp_path / "b.yaml"
    source.write_text("# Controller\nx: 1.0\n")
    write_copy(source, copy, {"x": 2.0}, "today, drive.bag")
    assert copy.read_text() == "# Identified: today, drive.bag\n# Controller\nx: 2.0\n"
    write_copy(copy, source, {"x": 3.0}, "tomorrow")
    assert source.read_text() == "# Identified: tomorrow\n# Controller\nx: 3.0\n"


def test_the_shipped_settings_are_the_defaults() -> None:
    assert load_file(IdentifySettings, CONFIG / "identify.yaml") == IdentifySettings()
    assert load_file(Chair, CONFIG / "chair.yaml") == Chair()
