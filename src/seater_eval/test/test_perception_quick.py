"""The perception commands run from end to end (--quick): files, exit code, table, progress. Whether bars are met is what the
commands are for, and so few pictures do not show it: here the exit code has to say what the file says."""

import json
import os
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

ROOT = Path(__file__).resolve().parents[3]
NODES = Path(__file__).resolve().parents[1] / "nodes"


def run(command: str, results: Path, *options: str, config: Path = ROOT / "config") -> subprocess.CompletedProcess[str]:
    words = [
        sys.executable,
        str(NODES / command),
        "--quick",
        "--results",
        str(results),
        "--config",
        str(config),
        *options,
    ]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(words, capture_output=True, text=True, timeout=600, env=environment)


@pytest.mark.parametrize(
    ("command", "bars", "options"),
    [("perception_accuracy", 7, ()), ("perception_range", 10, ("--negatives", "20")), ("perception_speed", 4, ())],
)
def test_quick_version(command: str, bars: int, options: tuple[str, ...], tmp_path: Path) -> None:
    ended = run(command, tmp_path, *options)
    assert ended.returncode in (0, 1), ended.stderr
    data = json.loads((tmp_path / f"{command}.json").read_text())
    assert data["command"] == command
    assert data["quick"] is True
    assert len(data["bars"]) >= bars
    assert ended.returncode == (0 if all(bar["met"] for bar in data["bars"]) else 1)
    for bar in data["bars"]:
        assert bar.keys() >= {"name", "value", "limit", "met"}
        assert bar["name"] in ended.stdout
    assert "left" in ended.stderr  # the progress line's remaining time
    picture = cv2.imread(str(tmp_path / f"{command}.png"))
    assert picture is not None
    assert picture.std() > 5.0
    assert not list(tmp_path.glob("*.partial.jsonl"))


@pytest.mark.parametrize("command", ["perception_accuracy", "perception_range", "perception_speed"])
def test_wrong_configuration(command: str, tmp_path: Path) -> None:
    config = tmp_path / "config"
    (config / "cameras").mkdir(parents=True)
    for name in ("perception.yaml", "cameras/degraded.yaml"):
        (config / name).write_text((ROOT / "config" / name).read_text())
    wrong = config / "perception.yaml"
    wrong.write_text(wrong.read_text().replace("corner_sigma: 0.05", "corner_sigma: -1.0"))
    ended = run(command, tmp_path, config=config)
    assert ended.returncode == 2
    assert "pose/corner_sigma" in ended.stderr
    assert "-1" in ended.stderr
    assert not list(tmp_path.glob("*.json*"))
