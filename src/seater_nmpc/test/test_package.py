"""What holds for the package as a whole: no ROS in the core, configuration, numbers shared with the messages."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from seater_common.geometry import CameraMount, Chair, Dock
from seater_common.params import ParameterError, as_mapping, load
from seater_common.se2 import inverse
from seater_nmpc.control.command import Status
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.observe.odometry.message import Odometry
from seater_nmpc.parameters import NmpcParameters
from seater_nmpc.sequence.goal.results import Phase, ResultCode
from seater_nmpc.sequence.shadow import Shadow

ROOT = Path(__file__).resolve().parents[3]


def test_core_imports_no_ros() -> None:
    package = ROOT / "src/seater_nmpc/src/seater_nmpc"
    sources = [source for source in package.rglob("*.py") if "ros" not in source.relative_to(package).parts]
    assert len(sources) > 10
    for source in sources:
        assert not re.search(
            r"^\s*(import|from)\s+(rospy|tf|actionlib|\w+_msgs|seater_nmpc.ros)", source.read_text(), re.M
        )


def test_the_core_does_not_wait_for_opencv() -> None:
    """Which only a bent lens needs, and which takes as long to load as everything else."""
    asked = f"""
import sys, numpy, seater_nmpc.control.controller, seater_nmpc.checks.setup
from seater_common.camera_model import CameraModel
camera = CameraModel.load("{ROOT}/config/cameras/d455.yaml")
assert not numpy.isnan(camera.ray(numpy.zeros((1, 2)))).any()
sys.exit("cv2" in sys.modules)"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run([sys.executable, "-c", asked], env=environment).returncode == 0


def test_configuration_loads_and_every_key_says_what_it_is() -> None:
    file = ROOT / "config/controller.yaml"
    values = yaml.safe_load(file.read_text())
    parameters = load(NmpcParameters, values, "controller")
    assert parameters.control.horizon == 30
    for line in file.read_text().splitlines():
        if re.match(r"\s*\w+: *\S", line) and not re.match(r"\s*\w+: *#", line):
            assert "#" in line and "default" in line, line


def test_configuration_is_the_defaults() -> None:
    """Both are those of a typical powered chair; `./seater identify` writes what another one needs."""
    values = yaml.safe_load((ROOT / "config/controller.yaml").read_text())
    assert load(NmpcParameters, values, "controller") == NmpcParameters()


def test_a_wrong_key_is_named_in_full() -> None:
    values = as_mapping(NmpcParameters())
    values["control"]["solver"] = "magic"
    values["sequence"]["max_blind_distance"] = -1.0
    with pytest.raises(ParameterError) as caught:
        load(NmpcParameters, values, "controller")
    for word in ("controller/control/solver", "magic", "ipopt", "controller/sequence/max_blind_distance", "-1.0"):
        assert word in str(caught.value)


def test_the_old_place_of_the_time_limit_is_named() -> None:
    """It moved from control/ipopt to control, as it holds for every solver."""
    values = as_mapping(NmpcParameters())
    values["control"]["ipopt"]["max_wall_time"] = values["control"].pop("max_wall_time")
    with pytest.raises(ParameterError) as caught:
        load(NmpcParameters, values, "controller")
    assert "controller/control/ipopt/max_wall_time: unknown key" in str(caught.value)
    assert "controller/control/max_wall_time: is missing" in str(caught.value)


def test_numbers_are_those_of_the_messages() -> None:
    """Read from the message definitions themselves, so that no built workspace is needed."""
    action = (ROOT / "src/seater_msgs/action/Dock.action").read_text()
    status = (ROOT / "src/seater_msgs/msg/ControllerStatus.msg").read_text()

    def constants(text: str) -> dict[str, int]:
        return {name: int(value) for name, value in re.findall(r"^uint\d+ ([A-Z_]+)=(\d+)", text, re.M)}

    _, results, feedback = action.split("---")
    assert constants(results) == {code.name: code.value for code in ResultCode}
    assert constants(feedback) == {phase.name: phase.value for phase in Phase}
    assert constants(status) == {s.name: s.value for s in Status}
    innovation = (ROOT / "src/seater_msgs/msg/DockInnovation.msg").read_text()
    assert constants(innovation) == {outcome.name: outcome.value for outcome in Outcome}


def test_shadow_computes_without_a_goal_once_the_dock_is_seen(controller: DockingController) -> None:
    from conftest import observation

    observer = DockObserver(CameraMount(), standing=False)
    shadow = Shadow(controller, observer, max_age=3.0)
    truth = np.array([-2.0, 0.1, 0.0])
    observer.add_odometry(Odometry(1.0, truth, 0.3, 0.0))
    assert shadow.update(1.0) is None
    for k in range(5):
        observer.add_detections(1.0, [observation(Chair(), inverse(truth))])
        assert k < 4 or shadow.update(1.0) is not None
    command = shadow.update(1.0)
    assert command is not None and command.v == pytest.approx(0.3 + 0.025, abs=1e-6)
    assert Dock().predock_x < 0.0
