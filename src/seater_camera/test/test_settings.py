"""The shipped file is complete, and says what the code takes without it."""

from pathlib import Path

from seater_camera.settings import CameraSettings
from seater_common.params import load, read_yaml

FILE = Path(__file__).resolve().parents[3] / "config" / "camera.yaml"


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(CameraSettings, read_yaml(FILE), "camera") == CameraSettings()
