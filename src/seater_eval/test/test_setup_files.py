"""Files of a run: read and checked before anything starts, errors name file and keys."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from seater_common.params import ParameterError
from seater_eval.run.setup_files import SetupFiles, load_files, load_setup

CONFIG = Path(__file__).resolve().parents[3] / "config"
FILES = SetupFiles.of(CONFIG)


def changed(tmp_path: Path, name: str, **changes: object) -> SetupFiles:
    """FILES with a copy of one file, top-level keys replaced."""
    file = tmp_path / f"my_{name}.yaml"
    file.write_text(yaml.safe_dump(yaml.safe_load(FILES.paths()[name].read_text()) | changes))
    return replace(FILES, **{name: file})


def test_the_shipped_files_load_without_a_warning() -> None:
    setup, warnings = load_files(FILES)
    assert warnings == [] and setup == replace(load_setup(CONFIG), camera=setup.camera)


def test_a_narrow_bay_is_a_warning_or_an_error_with_the_file(tmp_path: Path) -> None:
    bay = yaml.safe_load(FILES.dock.read_text())["bay"]
    setup, (narrow, *hidden) = load_files(changed(tmp_path, "dock", bay=bay | {"width": 0.8}))
    assert setup.parameters.control.margin < 0.05 and "dock bay/width" in narrow
    assert len(hidden) == 2 and all("the wall hides it" in warning for warning in hidden)  # the outer ones
    with pytest.raises(ParameterError, match=r"(?s)dock bay/width, chair width.*my_dock\.yaml"):
        load_files(changed(tmp_path, "dock", bay=bay | {"width": 0.7}))


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("chair", {"width": "wide"}, "my_chair.yaml/width"),
        ("controller", {"planner": None}, "my_controller.yaml/planner"),
        ("simulator", {"step": -1.0}, "my_simulator.yaml/step"),
        ("camera", {"distortion_model": "fisheye"}, "my_camera.yaml/distortion_model"),
        ("perception", {"selection": "best"}, r"(?s)my_perception\.yaml.*selection"),
    ],
)
def test_wrong_keys_are_named_with_their_file(tmp_path: Path, name: str, changes: dict, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        load_files(changed(tmp_path, name, **changes))


@pytest.mark.parametrize("name", list(SetupFiles.__dataclass_fields__))
def test_a_missing_file_is_named(tmp_path: Path, name: str) -> None:
    with pytest.raises(ParameterError, match=r"nowhere\.yaml"):
        load_files(replace(FILES, **{name: tmp_path / "nowhere.yaml"}))


def test_a_perception_file_that_is_no_mapping_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "my_perception.yaml"
    file.write_text("- a list\n")
    with pytest.raises(ParameterError, match=r"my_perception\.yaml"):
        load_files(replace(FILES, perception=file))
