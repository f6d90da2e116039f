"""The perception commands refuse a wrong configuration. Their --quick versions run with `./seater test --all`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
NODES = Path(__file__).resolve().parents[1] / "nodes" / "perception"


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
    "command",
    [
        "perception_accuracy",
        *[pytest.param(f"perception_{name}", marks=pytest.mark.extensive) for name in ("range", "shadows", "speed")],
    ],
)
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
    assert not list(tmp_path.glob("perception_*"))
