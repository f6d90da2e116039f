"""The shipped file is complete, and says what the code takes without it."""

from pathlib import Path

from seater_common.params import load, read_yaml
from seater_obstacles.settings import ObstacleSettings

FILE = Path(__file__).resolve().parents[3] / "config" / "obstacles.yaml"


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load(ObstacleSettings, read_yaml(FILE), "obstacles") == ObstacleSettings()
