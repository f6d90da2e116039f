#!/usr/bin/env python3
"""Every launch file of seater_bringup can be resolved, and the wheelchair's has no simulator inside."""

import argparse
import functools
import shlex
import sys
import unittest
from pathlib import Path

import rospkg
import rostest
from roslaunch import RLException
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

from seater_tools.command import doctor
from seater_tools.episodes.topics import TOPICS

CONFIG = Path(rospkg.RosPack().get_path("seater_config"))
LAUNCH = Path(rospkg.RosPack().get_path("seater_bringup")) / "launch"


@functools.cache
def resolve(launch_file: str, *arguments: str) -> ROSLaunchConfig:
    """As roslaunch does before it starts anything, but for roscore's own file, which takes longer than all of ours.
    Raises RLException when the file is wrong."""
    config = ROSLaunchConfig()
    XmlLoader().load(str(LAUNCH / launch_file), config, argv=list(arguments), verbose=False)
    config.assign_machines()
    return config


def nodes(launch_file: str, *arguments: str) -> set[str]:
    return {node.namespace + node.name for node in resolve(launch_file, *arguments).nodes}


def parameters(launch_file: str, *arguments: str) -> dict[str, object]:
    return {name: param.value for name, param in resolve(launch_file, *arguments).params.items()}


def panel_arguments(launch_file: str, *arguments: str) -> str:
    return next(node.args for node in resolve(launch_file, *arguments).nodes if node.name == "panel")


def recorded(*arguments: str) -> list[str]:
    return next(node.args for node in resolve("record.launch", *arguments).nodes if node.name == "record").split()


class LaunchFiles(unittest.TestCase):
    def test_simulation(self) -> None:
        self.assertEqual(nodes("sim.launch"), {"/sim", "/marker_detector", "/docking", "/safety_gate"})
        self.assertIn("/record", nodes("sim.launch", "record:=true"))

    def test_the_simulated_chair_is_as_it_is_unless_another_is_asked_for(self) -> None:
        kind = "/sim/simulator/plant/kind"
        self.assertEqual(parameters("sim.launch")[kind], "wheelchair")
        self.assertEqual(parameters("sim.launch", "plant:=kinematic")[kind], "kinematic")

    def test_wheelchair_has_no_simulator(self) -> None:
        self.assertEqual(
            nodes("wheelchair.launch"),
            {"/marker_detector", "/docking", "/safety_gate", "/camera_tf", "/history", "/docking_bags"},
        )
        self.assertNotIn("/docking_bags", nodes("wheelchair.launch", "docking_bags:=none"))
        self.assertIn("/metrics", nodes("wheelchair.launch", "metrics:=9187"))
        self.assertNotIn("/history", nodes("wheelchair.launch", "history:=none"))
        self.assertNotIn("/camera_tf", nodes("wheelchair.launch", "publish_camera_tf:=false"))
        self.assertNotIn("/use_sim_time", parameters("wheelchair.launch"))
        check = "/docking/controller/sequence/installation_check"
        self.assertEqual([parameters(f"{of}.launch")[check] for of in ("wheelchair", "sim")], ["on_the_way", "never"])

    def test_wheelchair_camera_mount_reaches_every_user(self) -> None:
        values = parameters("wheelchair.launch", "camera_x:=0.33", "camera_pitch:=0.12")
        for node in ("docking", "marker_detector", "camera_tf"):
            self.assertEqual(values[f"/{node}/chair/camera/x"], 0.33)
            self.assertEqual(values[f"/{node}/chair/camera/pitch"], 0.12)

    def test_the_cameras_calibration_reaches_the_controller(self) -> None:
        file = str(CONFIG / "cameras" / "d455.yaml")
        self.assertEqual(parameters("sim.launch")["/docking/camera/image_width"], 1280)
        self.assertNotIn("/docking/camera/image_width", parameters("wheelchair.launch"))
        values = parameters("wheelchair.launch", f"camera_file:={file}", "rectified:=true")
        self.assertEqual(values["/docking/camera/image_width"], 1280)
        self.assertIs(values["/docking/rectified"], True)

    def test_a_camera_of_ours_where_it_is_asked_for(self) -> None:
        file = str(CONFIG / "cameras" / "d455.yaml")
        self.assertEqual(nodes("wheelchair.launch", "camera:=v4l2") - nodes("wheelchair.launch"), {"/camera"})
        values = parameters("wheelchair.launch", "camera:=realsense", f"camera_file:={file}", "optical_frame:=eye")
        self.assertEqual((values["/camera/source"], values["/camera/frame"]), ("realsense", "eye"))
        self.assertEqual(values["/camera/calibration/image_width"], 1280)
        self.assertEqual(values["/camera/settings/format/rate"], 30)
        self.assertNotIn("/camera/calibration/image_width", parameters("camera.launch", "source:=v4l2"))
        (camera,) = (node for node in resolve("wheelchair.launch", "camera:=v4l2").nodes if node.name == "camera")
        self.assertIn(["camera_info", "camera/color/camera_info"], [list(pair) for pair in camera.remap_args])

    def test_a_recording_does_not_drive_the_chair(self) -> None:
        with self.assertRaises(RLException):
            nodes("wheelchair.launch", "camera:=recorded")

    def test_the_base_driver(self) -> None:
        self.assertEqual(nodes("base.launch"), {"/base"})
        self.assertNotIn("/base/port", parameters("base.launch"))
        self.assertEqual(parameters("base.launch", "port:=/dev/ttyUSB3")["/base/port"], "/dev/ttyUSB3")
        self.assertEqual(parameters("base.launch")["/base/base/silence"], 0.3)
        told = parameters("base.launch", f"deflection:={CONFIG / 'deflection.yaml'}", "charging:=true")
        self.assertEqual((told["/base/deflection/drive/neutral"], told["/base/charging"]), (2.5, True))

    def test_joystick_and_emergency_stop_where_they_are_asked_for(self) -> None:
        hold, timeout = "/safety_gate/safety/hold_to_run", "/safety_gate/safety/emergency_stop_timeout"
        launch = resolve("wheelchair.launch", "joystick:=evdev", "joystick_hold:=true", "emergency_stop:=gpio")
        self.assertLess({"joystick", "emergency_stop_contact"}, {node.name for node in launch.nodes})
        values = {name: param.value for name, param in launch.params.items()}
        self.assertEqual((values[hold], values["/joystick/hold"], values[timeout]), (1, True, 0.5))
        self.assertEqual(values["/emergency_stop_contact/emergency_stop/lines"], [17])
        launch = resolve("wheelchair.launch", "joystick:=evdev")
        self.assertNotIn("emergency_stop_contact", {node.name for node in launch.nodes})
        values = {name: param.value for name, param in launch.params.items()}
        self.assertEqual((values[hold], values["/joystick/hold"], values[timeout]), (0, False, 0.0))

    def test_what_does_not_fit_together_does_not_start(self) -> None:
        for launch_file, *wrong in (
            ("controls.launch", "joystick:=js0"),
            ("controls.launch", "emergency_stop:=usb"),
            ("wheelchair.launch", "joystick_hold:=true"),
            ("wheelchair.launch", "joystick:=evdev", "joystick_hold:=true", "panel:=true"),
        ):
            with self.assertRaisesRegex(RLException, "_is_|_needs_", msg=str(wrong)):
                nodes(launch_file, *wrong)

    def test_panel_and_rviz(self) -> None:
        watching = nodes("wheelchair.launch", "panel:=true", "rviz:=true") - nodes("wheelchair.launch")
        self.assertEqual(watching, {"/panel", "/scene", "/rviz"})

    def test_the_panels_doctor_is_told_the_files_and_topics_of_the_launch(self) -> None:
        said = "panel:=true", "chair_file:=/tmp/my chair.yaml", "image:=front/image", "image_transport:=compressed"
        with self.assertRaisesRegex(RLException, "my chair"):  # such a file would have to be there
            parameters("wheelchair.launch", *said)
        words = shlex.split(str(parameters("wheelchair.launch", said[0], *said[2:])["/panel/doctor"]))
        self.assertEqual(words[words.index("--image") + 1], "front/image")
        self.assertEqual(words[words.index("--chair") + 1], str(CONFIG / "chair.yaml"))
        self.assertIn("--compressed", words)
        parser = argparse.ArgumentParser()
        doctor.add_options(parser, CONFIG)
        parser.parse_args(words)

    def test_the_panel_has_buttons_only_with_a_gate_that_watches_them(self) -> None:
        hold = "/safety_gate/safety/hold_to_run"
        for launch in (("wheelchair.launch",), ("sim.launch", "lock_step:=false")):
            self.assertEqual(parameters(*launch)[hold], 0)
            self.assertEqual(parameters(*launch, "panel:=true")[hold], 1)
            self.assertNotIn("--view-only", panel_arguments(*launch, "panel:=true"))
        self.assertEqual(parameters("sim.launch", "panel:=true")[hold], 0)
        self.assertIn("--view-only", panel_arguments("sim.launch", "panel:=true"))
        self.assertIn("--view-only", panel_arguments("watch.launch", "panel:=true"))
        self.assertIn("--port 8500", panel_arguments("wheelchair.launch", "panel:=true", "panel_options:=--port 8500"))

    def test_record_and_replay(self) -> None:
        self.assertEqual(nodes("record.launch", "bag:=x.bag"), {"/record"})
        # All that the small bag of a docking has: goals, emergency stop, joystick, gate.
        words = recorded("bag:=x.bag")
        self.assertEqual(set(TOPICS) - set(words), set())
        self.assertIn("--lz4", words)
        self.assertNotIn("--split", words)
        words = recorded("bag:=x.bag", "compression:=bz2", "split:=500", "more:=scan points")
        self.assertLessEqual({"--bz2", "--split", "--size=500", "scan", "points"}, set(words))
        self.assertNotIn("--lz4", words)
        with self.assertRaisesRegex(RLException, "zip"):
            recorded("bag:=x.bag", "compression:=zip")
        self.assertEqual(nodes("replay.launch", "bag:=x.bag"), {"/marker_detector", "/docking", "/replay"})
        alone = nodes("replay.launch", "bag:=x.bag", "controller:=false")
        self.assertEqual(alone, {"/marker_detector", "/replay"})


if __name__ == "__main__":
    rostest.rosrun("seater_test", "launch_files", LaunchFiles, sys.argv)
