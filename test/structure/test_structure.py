"""Rules of the layout that a reader relies on."""

import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
PYTHON_ROS = re.compile(r"^\s*(?:import|from)\s+(rospy|rosbag|actionlib|tf2_ros|tf|cv_bridge|\w+_msgs)\b", re.MULTILINE)
CPP_ROS = re.compile(
    r"#include\s*[<\"]"
    r"(ros/|nodelet/|image_transport/|cv_bridge/|tf2\w*/|diagnostic_updater/|message_filters/|\w+_msgs/)"
)


def is_adapter(path: Path) -> bool:
    """What lies in a folder `ros` or `*_ros`, in `nodes`, or is a `*_node`, talks to ROS."""
    relative = path.relative_to(ROOT)
    return any(p == "ros" or p.endswith("_ros") or p == "nodes" for p in relative.parts) or path.stem.endswith("_node")


def programs() -> list[Path]:
    """Those in Python that people or launch files start."""
    found = [p for folder in ("nodes", "evaluation") for p in sorted(ROOT.glob(f"src/seater_*/{folder}/**/*"))]
    return [p for p in found if p.is_file() and p.suffix == "" and p.read_text().startswith("#!/usr/bin/env python3")]


@pytest.mark.parametrize("path", programs(), ids=lambda p: str(p.relative_to(ROOT)))
def test_programs_begin_with_what_answers_ctrl_c(path: Path) -> None:
    imports = re.findall(r"^(?:import|from) (?!__future__)([\w.]+)", path.read_text(), re.MULTILINE)
    assert imports[0] == "seater_common.command.interrupt"


def test_programs_that_people_start_end_with_a_line() -> None:
    """Those of the reference: with an exit status and a cause, not where in Python they were."""
    known = set(re.findall(r"\w+", (ROOT / "docs" / "reference" / "commands.md").read_text()))
    texts = [(path, path.read_text()) for path in programs() if path.name in known and path.parts[-3] != "seater_sim"]
    assert len(texts) > 25
    assert [path for path, text in texts if "ended(" not in text and "init_node(" not in text] == []


def core_files(pattern: str) -> list[Path]:
    return [p for p in sorted(ROOT.glob(pattern)) if not is_adapter(p)]


@pytest.mark.parametrize("path", core_files("src/seater_*/src/**/*.py"), ids=lambda p: str(p.relative_to(ROOT)))
def test_python_core_imports_no_ros(path: Path) -> None:
    # Imports inside a function are allowed to read bags and nothing else.
    found = [m.group(1) for m in PYTHON_ROS.finditer(path.read_text()) if m.group(0).strip() != "import rosbag"]
    assert found == []


@pytest.mark.parametrize(
    "path",
    core_files("src/seater_*/include/**/*.h")
    + core_files("src/seater_*/src/**/*.h")
    + core_files("src/seater_*/src/**/*.cpp")
    + core_files("src/seater_*/python/*"),
    ids=lambda p: str(p.relative_to(ROOT)),
)
def test_cpp_core_includes_no_ros(path: Path) -> None:
    assert CPP_ROS.findall(path.read_text()) == []


@pytest.mark.parametrize(
    "path", [p for p in sorted(ROOT.glob("src/seater_*/**/*")) if p.parts[-2] == "nodes" or p.suffix == ".py"],
    ids=lambda p: str(p.relative_to(ROOT)),
)  # fmt: skip
def test_yaml_files_are_read_by_the_one_reader_that_names_what_is_wrong_with_them(path: Path) -> None:
    if "test" not in path.parts and path.is_file():
        assert not re.search(r"safe_load\(.*(read_text|open)\(", path.read_text())


@pytest.mark.parametrize(
    ("package", "program"), sorted(set(re.findall(r"exec rosrun (\w+) (\w+)", (ROOT / "seater").read_text())))
)
def test_commands_end_with_a_line_and_no_traceback(package: str, program: str) -> None:
    assert "ended(" in (ROOT / "src" / package / "nodes" / program).read_text()


def test_an_unknown_command_is_one_line_and_wrong_input() -> None:
    done = subprocess.run([ROOT / "seater", "dokc"], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stdout == ""
    assert "unknown command: dokc" in done.stderr and len(done.stderr.splitlines()) == 1


def test_there_are_cores_to_check() -> None:
    assert len(core_files("src/seater_*/src/**/*.py")) > 15
    assert len(core_files("src/seater_*/src/**/*.cpp")) > 5


@pytest.mark.parametrize("launch", sorted(ROOT.glob("src/seater_bringup/launch/*.launch")), ids=lambda p: p.name)
def test_launch_files_use_no_absolute_topic_names(launch: Path) -> None:
    assert not re.search(r'<remap[^>]*"/', launch.read_text())


@pytest.mark.parametrize("launch", sorted(ROOT.glob("src/seater_bringup/launch/*.launch")), ids=lambda p: p.name)
def test_launch_arguments_say_what_they_mean(launch: Path) -> None:
    """`roslaunch --ros-args` shows it."""
    arguments = [entry for entry in ElementTree.parse(launch).getroot().findall("arg") if "value" not in entry.attrib]
    assert [entry.attrib["name"] for entry in arguments if not entry.attrib.get("doc")] == []


@pytest.mark.parametrize("script", ["seater", "tools/make_venv.sh", "tools/lint.sh", "tools/run_tests.py", ".ci/run"])
def test_scripts_are_executable(script: str) -> None:
    assert (ROOT / script).stat().st_mode & 0o111
