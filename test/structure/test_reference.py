"""The reference pages say what the code says."""

import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INTERFACES = (ROOT / "docs" / "reference" / "interfaces.md").read_text()
CONSTANT = re.compile(r"^uint\d+ ([A-Z_]+)=(\d+)", re.MULTILINE)


def section(title: str) -> str:
    """The text of a section of interfaces.md."""
    return INTERFACES.partition(f"\n## {title}\n")[2].partition("\n## ")[0]


@pytest.mark.skipif(find_spec("seater_perception") is None, reason="seater_perception is not built: ./seater build")
def test_parameters_are_those_of_the_structs() -> None:
    words = [sys.executable, str(ROOT / "tools" / "generate_reference.py"), "--check"]
    run = subprocess.run(words, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


def test_the_figure_shows_the_rooms_and_arrows_of_today() -> None:
    words = [sys.executable, str(ROOT / "tools" / "draw_architecture.py"), "--check"]
    run = subprocess.run(words, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.skipif(find_spec("seater_perception") is None, reason="seater_perception is not built: ./seater build")
@pytest.mark.parametrize("tool", sorted((ROOT / "tools").glob("*.py")), ids=lambda path: path.name)
def test_tools_start(tool: Path) -> None:
    """What they import is there: nothing else runs result_snapshot.py."""
    run = subprocess.run([sys.executable, str(tool), "--help"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("command", ["setup", "build", "test", "lint", "sanitize", "package", "run"])
def test_help_neither_installs_nor_builds(command: str, tmp_path: Path) -> None:
    """It did, for ten minutes, before it printed anything."""
    (tmp_path / "tools").mkdir()
    for file in ("seater", "CMakeLists.txt", "tools/run_tests.py"):
        shutil.copy(ROOT / file, tmp_path / file)
    run = subprocess.run([tmp_path / "seater", command, "--help"], capture_output=True, text=True, timeout=20)
    assert run.returncode == 0 and run.stdout.startswith(f"  {command} "), run.stdout + run.stderr
    assert ("--match" in run.stdout) == (command in ("test", "sanitize"))
    assert {path.name for path in tmp_path.iterdir()} <= {"seater", "CMakeLists.txt", "tools"}


def test_result_codes_are_those_of_the_action_and_each_says_what_to_do() -> None:
    _, result, feedback = (ROOT / "src/seater_msgs/action/Dock.action").read_text().split("---")
    codes = {(number, name) for name, number in CONSTANT.findall(result)}
    text = section("Result codes")
    assert set(re.findall(r"^\| (\d+) \| ([A-Z_]+) \|", text, re.MULTILINE)) == codes
    advised = {(number, name) for name, number in re.findall(r"^- \*\*([A-Z_]+) \((\d+)\)\*\*: ", text, re.MULTILINE)}
    assert advised == {(number, name) for number, name in codes if int(number) >= 900}
    phases = set(re.findall(r"^\| (\d+) \| ([A-Z_]+) \|", section("Phases"), re.MULTILINE))
    assert phases == {(number, name) for name, number in CONSTANT.findall(feedback)}


def test_every_message_and_status_is_listed() -> None:
    folder, text = ROOT / "src" / "seater_msgs" / "msg", section("Messages")
    assert set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)) == {path.stem for path in folder.glob("*.msg")}
    titles = {"Messages": "ControllerStatus", "Innovations": "DockInnovation", "Dock state": "DockState"}
    for title, message in titles.items():
        constants = {(number, name) for name, number in CONSTANT.findall((folder / f"{message}.msg").read_text())}
        assert set(re.findall(r"^\| (\d+) \| ([A-Z_]+) \|", section(title), re.MULTILINE)) == constants


def test_the_states_of_the_gate_are_those_of_its_message() -> None:
    message = (ROOT / "src/seater_msgs/msg/GateState.msg").read_text()
    listed = re.findall(r"^\| (\d+) \| ([A-Z_]+) \|", (ROOT / "docs/safety.md").read_text(), re.MULTILINE)
    assert listed == [(number, name) for name, number in CONSTANT.findall(message)]


def test_every_topic_of_the_docking_node_is_listed() -> None:
    source = "".join(path.read_text() for path in ROOT.glob("src/seater_nmpc/src/seater_nmpc/ros/*.py"))
    published = set(re.findall(r"rospy\.Publisher\(\s*\"(\w+)\"", source))
    assert len(published) > 3
    assert published <= set(re.findall(r"`(\w+)`", section("Topics")))
