"""The workspace's install rules, on a project with one program: DESTDIR, interpreter, a prefix that stays."""

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = """
cmake_minimum_required(VERSION 3.18)
project(workspace LANGUAGES NONE)
set(Python3_EXECUTABLE /the/python3)
include({root}/tools/packaging/install_space.cmake)
install(PROGRAMS program DESTINATION lib/seater_part)
seater_install_interpreter()
"""


class Workspace:
    """Configured for `prefix`; nothing is installed yet."""

    def __init__(self, folder: Path) -> None:
        self.source, self.build, self.prefix = folder / "source", folder / "build", folder / "prefix"
        self.source.mkdir()
        (self.source / "CMakeLists.txt").write_text(PROJECT.format(root=ROOT))
        (self.source / "program").write_text("#!/usr/bin/env python3\nprint()\n")
        words = ["cmake", "-S", self.source, "-B", self.build, f"-DCMAKE_INSTALL_PREFIX={self.prefix}"]
        self.said = subprocess.run(words, check=True, capture_output=True, text=True).stdout

    def install(self, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
        command = ["cmake", "--install", str(self.build), *words]
        return subprocess.run(command, env=os.environ | environment, capture_output=True, text=True)


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return Workspace(tmp_path)


def check_installed(prefix: Path) -> None:
    assert (prefix / "lib/seater_part/program").read_text() == "#!/the/python3\nprint()\n"
    assert (prefix / "CATKIN_IGNORE").exists()


def test_installs_to_the_prefix(workspace: Workspace) -> None:
    assert workspace.install().returncode == 0
    check_installed(workspace.prefix)


def test_destdir_is_honoured(workspace: Workspace, tmp_path: Path) -> None:
    assert workspace.install(DESTDIR=str(tmp_path / "stage")).returncode == 0
    check_installed(tmp_path / "stage" / workspace.prefix.relative_to("/"))
    assert not workspace.prefix.exists()


def test_configuring_says_that_the_install_space_cannot_be_moved(workspace: Workspace) -> None:
    assert f"install space is {workspace.prefix} and cannot be moved" in " ".join(workspace.said.split())


def test_another_prefix_when_installing_is_refused_with_the_remedy(workspace: Workspace, tmp_path: Path) -> None:
    done = workspace.install("--prefix", str(tmp_path / "else"))
    assert done.returncode != 0 and f"-DCMAKE_INSTALL_PREFIX={tmp_path / 'else'}" in " ".join(done.stderr.split())
    assert not (tmp_path / "else").exists()
