"""The unit that starts the chair at boot: systemd takes it, and it ends as Ctrl-C does."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1]
UNIT = PACKAGE / "systemd" / "seater.service"


def unit() -> configparser.ConfigParser:
    parser = configparser.ConfigParser(interpolation=None, strict=False)
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read(UNIT)
    return parser


def start() -> str:
    return unit()["Service"]["ExecStart"]


def settings() -> dict[str, str]:
    lines = (PACKAGE / "systemd" / "seater.conf").read_text().splitlines()
    pairs = (line.split("=", 1) for line in lines if line and not line.startswith("#"))
    return {name: value.strip('"') for name, value in pairs}


def test_systemd_finds_nothing_wrong() -> None:
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is missing")
    done = subprocess.run(["systemd-analyze", "verify", UNIT], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and UNIT.name not in done.stderr, done.stderr


def test_it_ends_as_ctrl_c_does_and_begins_again_after_a_failure() -> None:
    """SIGINT reaches roslaunch alone (mixed), which ends the nodes in order; the gate's last message is zero."""
    service = unit()["Service"]
    assert (service["KillSignal"], service["KillMode"]) == ("SIGINT", "mixed")
    assert service["Restart"] == "always" and int(service["TimeoutStopSec"]) >= 20  # roslaunch gives nodes 15 s
    assert " exec roslaunch " in start()  # no shell in between


def test_the_arguments_are_those_of_the_launch_file() -> None:
    launch = ElementTree.parse(PACKAGE / "launch" / "wheelchair.launch").getroot()
    known = {arg.attrib["name"] for arg in launch.findall("arg")}
    given = set(re.findall(r"([a-z_]+):=", start() + " " + settings()["SEATER_ARGUMENTS"]))
    assert {"installation", "history", "docking_bags"} <= given <= known


def test_every_variable_of_the_unit_is_in_the_settings() -> None:
    assert set(re.findall(r"\$([A-Z_]+)", start())) <= set(settings())


def test_what_programs_keep_goes_where_the_user_may_write() -> None:
    """The user has no home: the panel, which keeps its token, would not start."""
    lines = [line for line in UNIT.read_text().splitlines() if line.startswith("Environment=")]
    kept = dict(word.split("=", 1) for line in lines for word in line.removeprefix("Environment=").split())
    state = Path("/var/lib") / unit()["Service"]["StateDirectory"]
    assert Path(kept["HOME"]) == Path(kept["XDG_STATE_HOME"]) / "seater" == Path(kept["ROS_HOME"]) == state


@pytest.mark.parametrize("name", ["seater.service", "seater.logrotate"])
def test_they_agree_on_folders(name: str) -> None:
    assert "/var/log/seater" in (PACKAGE / "systemd" / name).read_text()


def test_logrotate_reads_its_file() -> None:
    program = shutil.which("logrotate") or shutil.which("logrotate", path="/usr/sbin")
    if program is None:
        pytest.skip("logrotate is missing")
    done = subprocess.run(
        [program, "--debug", PACKAGE / "systemd" / "seater.logrotate"], capture_output=True, text=True, timeout=60
    )
    assert "error: unknown" not in done.stderr.replace("unknown user", ""), done.stderr
