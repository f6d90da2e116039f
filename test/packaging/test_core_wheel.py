"""`pip install` of the controller without ROS: the wheel holds what its requirements suffice for, and no more."""

import importlib.util
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Iterator
from importlib.metadata import Distribution, PathDistribution
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
TEN_LINES = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", str(ROOT)]
    # No network: hatchling is Debian's.
    subprocess.run([*pip, "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder)], check=True)
    (path,) = folder.glob("seater_core-*.whl")
    return path


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a fresh virtual environment that knows the wheel and what it requires: nothing else, no ROS, no OpenCV."""
    folder = tmp_path_factory.mktemp("fresh")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    (site,) = folder.glob("lib/python3.*/site-packages")
    # What pip would do for a wheel without programs.
    zipfile.ZipFile(wheel).extractall(site)
    for place in required(PathDistribution(next(site.glob("seater_core-*.dist-info")))):
        (site / place.name).symlink_to(place)
    return folder / "bin" / "python3"


def required(core: Distribution) -> Iterator[Path]:
    """Where this interpreter has the modules of the wheel's requirements, for downloads take minutes."""
    for line in core.requires or []:
        name = re.match(r"[\w-]+", line)
        if name is not None and "extra ==" not in line:
            spec = importlib.util.find_spec({"pyyaml": "yaml"}.get(name[0].lower(), name[0]))
            assert spec is not None and spec.origin is not None, line
            yield Path(spec.origin).parent


def run(python: Path, code: str) -> str:
    # -I: neither PYTHONPATH of a sourced ROS nor this folder.
    done = subprocess.run([python, "-I", "-c", code], capture_output=True, text=True, timeout=100.0)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_ten_lines_of_the_readme_dock(python: Path) -> None:
    assert TEN_LINES is not None
    pose = [float(number) for number in run(python, TEN_LINES[1]).strip(" []\n").split()]
    # 0.02 mm and 0.002 deg were seen.
    assert all(abs(value) < 1e-3 for value in pose), pose


def test_every_module_of_the_wheel_needs_no_more_than_it_requires(python: Path, wheel: Path) -> None:
    files = [name for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".py")]
    modules = [name.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for name in files]
    assert {name.split(".")[0] for name in modules} == {"seater_common", "seater_nmpc"} and len(modules) > 100
    run(python, f"import importlib\nfor name in {modules!r}: importlib.import_module(name)")


def test_the_environment_has_no_ros(python: Path) -> None:
    run(python, "import importlib.util as u; assert not any(map(u.find_spec, ('rospy', 'seater_msgs', 'cv2')))")


def test_requirements_are_bounded_and_allow_what_the_tests_run_with() -> None:
    pinned = (ROOT / "tools" / "requirements.txt").read_text()
    for line in PROJECT["dependencies"]:
        name, low = re.fullmatch(r"([\w-]+)>=([\d.]+),<[\d.]+", line).groups()  # type: ignore[union-attr]
        if f"{name}==" in pinned:
            assert f"{name}=={low}" in pinned
