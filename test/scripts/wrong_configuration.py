#!/usr/bin/env python3
"""A node with a missing or impossible parameter does not start, and names the full key.

With `extensive` each node in more ways: what a reader of parameters makes of them has tests without a process.
"""

import subprocess
import sys
import unittest
from pathlib import Path

import rosgraph
import rospkg
import rospy
import rostest
import yaml

CONFIG = Path(rospkg.RosPack().get_path("seater_config"))


def read(name: str) -> dict:
    return yaml.safe_load((CONFIG / name).read_text())


def everything() -> dict:
    """Parameters with which every node starts."""
    return {
        "chair": read("chair.yaml"), "dock": read("docks/default.yaml"), "camera": read("cameras/d455.yaml"),
        "controller": read("controller.yaml"), "perception": read("perception.yaml"),
        "simulator": read("simulator.yaml"), "safety": read("safety.yaml"),
        "start": {"x": -2.0, "y": 0.0, "heading": 0.0}, "seed": 1, "start_paused": True, "lock_step": False,
        "rate": 0.0, "participants": [], "events": [], "shadow": False, "require_contact": False,
        "rectified": False, "image_transport": "raw",
    }  # fmt: skip


def extensive() -> bool:
    """Of `./seater test --all`: the launch file says so."""
    return bool(rospy.get_param("/extensive", False))


class WrongConfiguration(unittest.TestCase):
    def refuses(
        self, package: str, executable: str, path: str, value: object, says: tuple[str, ...] = (), known: bool = True
    ) -> None:
        """With the parameter at `path` replaced (None: removed) the node ends by itself and names the key, or `says`
        something else, and the value of a `known` key."""
        node = f"{executable}_{path.replace('/', '_')}"
        values = everything()
        *parents, last = path.split("/")
        inner = values
        for key in parents:
            inner = inner[key]
        inner.pop(last, None)
        if value is not None:
            inner[last] = value
        rosgraph.Master("/test").setParam("/" + node, values)
        command = ["rosrun", package, executable, f"__name:={node}"]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60)
        self.assertNotEqual(run.returncode, 0, run.stdout)
        for words in says or (path,):
            self.assertIn(words, run.stdout)
        self.assertNotIn("Traceback", run.stdout)
        if value is not None and known:
            self.assertIn(str(value), run.stdout)

    def test_docking_node(self) -> None:
        self.refuses("seater_nmpc", "docking_node", "dock/tolerance/position", "wide")
        if extensive():
            self.refuses("seater_nmpc", "docking_node", "chair/limits/v_max", None)
            self.refuses("seater_nmpc", "docking_node", "camera/distortion_model", "fisheye")

    def test_a_chair_that_does_not_fit_into_the_bay(self) -> None:
        """Before anything moves, naming both keys."""
        self.refuses("seater_nmpc", "docking_node", "dock/bay/width", 0.7, says=("dock bay/width", "chair width"))

    def test_sim_node(self) -> None:
        self.refuses("seater_sim", "sim_node", "dock/bay/width", -2.25)
        if extensive():
            self.refuses("seater_sim", "sim_node", "chair/width", None)

    def test_safety_gate(self) -> None:
        self.refuses("seater_safety", "safety_gate", "safety/request_timeout", None)
        self.refuses("seater_safety", "safety_gate", "safety/a_stop", 0.01)
        self.refuses("seater_safety", "safety_gate", "safety/a_stopp", 1.5, known=False)
        self.refuses("seater_safety", "safety_gate", "chair/limits/v_max", 50)

    def test_marker_detector(self) -> None:
        self.refuses("seater_perception", "marker_detector", "dock/dictionary", "DICT_9X9_9")
        self.refuses("seater_perception", "marker_detector", "rectified", None)
        if extensive():
            self.refuses("seater_perception", "marker_detector", "dock/dictionary", None)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "wrong_configuration", WrongConfiguration, sys.argv)
