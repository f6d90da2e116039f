"""What the Debian package says agrees with the sources, and its command `seater` works beside an install space."""

import os
import re
import shutil
import subprocess
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CONTROL = (ROOT / "debian" / "control").read_text()
DEVELOPERS = ("test", "lint", "sanitize", "package", "setup", "build")
# In the set-up for .venv, which the package does not have.
VENV = {"python3-venv"}


def packages(field: str) -> set[str]:
    """Names in a field of debian/control."""
    text = re.search(rf"^{field}:\n((?: .*\n)+)", CONTROL, re.MULTILINE)
    assert text is not None, field
    return set(re.findall(r"^ ([a-z0-9.+-]+)", text[1], re.MULTILINE))


def test_what_the_set_up_installs_the_package_names() -> None:
    lines = (ROOT / "tools" / "apt_packages.txt").read_text().splitlines()
    wanted = {name for line in lines if (name := line.partition("#")[0].strip())}
    assert wanted - VENV <= packages("Build-Depends") | packages("Depends")
    # The modules are imported when it runs; those two are for building.
    modules = {name for name in wanted if name.startswith("python3-")}
    assert modules - VENV - {"python3-pip"} <= packages("Depends")


def test_it_does_not_ask_for_what_only_building_needs() -> None:
    assert {name for name in packages("Depends") if name.endswith("-dev")} == set()


def test_one_version_and_one_maintainer() -> None:
    manifest = ElementTree.parse(ROOT / "config" / "package.xml").getroot()
    version, maintainer = manifest.findtext("version"), manifest.find("maintainer")
    assert (ROOT / "debian" / "changelog").read_text().startswith(f"seater ({version}) ")
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == version
    assert maintainer is not None
    assert f"Maintainer: {maintainer.text} <{maintainer.get('email')}>\n" in CONTROL


def test_python_that_debian_lacks_is_fetched() -> None:
    needed = re.search(r"^needed='(.*)'$", (ROOT / "tools" / "packaging" / "vendor.sh").read_text(), re.MULTILINE)
    assert needed is not None
    pinned = "".join((ROOT / "tools" / f"requirements{kind}.txt").read_text() for kind in ("", "_realsense"))
    assert all(re.search(rf"^{name}==", pinned, re.MULTILINE) for name in needed[1].split("|"))
    # Named in README: imported by the comparisons only, which say so when it is not there.
    rest = {"ruff", "mypy", "do-mpc", "optuna", "pandas", "pathspec", "pupil-apriltags"}
    assert set(re.findall(r"^([\w-]+)==", pinned, re.MULTILINE)) == rest | set(needed[1].split("|"))


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """`seater` as the package installs it, with a rosrun that prints what it was given."""
    home, programs = tmp_path / "lib" / "seater", tmp_path / "bin"
    home.mkdir(parents=True)
    programs.mkdir()
    shutil.copy(ROOT / "seater", home)
    (home / "setup.bash").write_text(f'export PATH="{programs}:$PATH"\n')
    (programs / "rosrun").write_text('#!/bin/sh\necho "$@" as $SEATER_COMMAND\n')
    (programs / "rosrun").chmod(0o755)
    (programs / "seater").symlink_to("../lib/seater/seater")
    return programs / "seater"


def typed(installed: Path, *words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"HOME": str(cwd / "home")}
    return subprocess.run([installed, *words], cwd=cwd, env=environment, capture_output=True, text=True)


def test_installed_command_neither_sets_up_nor_builds(installed: Path, tmp_path: Path) -> None:
    done = typed(installed, "dock", "--seed", "2", cwd=tmp_path)
    assert done.stdout == f"seater_eval dock_run --results {tmp_path}/results/dock --seed 2 as seater\n", done.stderr
    assert done.stderr == ""
    assert typed(installed, "run", "true", cwd=tmp_path).returncode == 0
    assert {path.name for path in (tmp_path / "lib" / "seater").iterdir()} == {"seater", "setup.bash"}


@pytest.mark.parametrize("command", DEVELOPERS)
def test_installed_command_says_what_needs_the_sources(installed: Path, tmp_path: Path, command: str) -> None:
    done = typed(installed, command, cwd=tmp_path)
    assert done.returncode == 1 and f"`{command}` needs the sources" in done.stderr


def test_help_of_the_installed_command_shows_what_it_can(installed: Path, tmp_path: Path) -> None:
    short, whole = typed(installed, "help", cwd=tmp_path), typed(ROOT / "seater", "help", cwd=tmp_path)
    commands = {re.match(r"  ([a-z]+)\b", line)[1] for line in whole.stdout.splitlines() if re.match(r"  [a-z]", line)}  # type: ignore[index]
    shown = {re.match(r"  ([a-z]+)\b", line)[1] for line in short.stdout.splitlines() if re.match(r"  [a-z]", line)}  # type: ignore[index]
    assert shown == commands - set(DEVELOPERS) and {"dock", "doctor", "help"} <= shown
    assert "./seater" not in short.stdout and short.stdout.startswith("usage: seater ")
    assert "usage: ./seater " in whole.stdout


def test_unknown_command_is_refused(installed: Path, tmp_path: Path) -> None:
    assert typed(installed, "dokc", cwd=tmp_path).returncode == 2
