#!/usr/bin/env python3
"""Every launch file of seater_bringup can be resolved, and the wheelchair's has no simulator inside."""

import subprocess
import sys
import unittest

import rostest


def nodes(launch_file: str, *arguments: str) -> set[str]:
    command = ["roslaunch", "--nodes", "seater_bringup", launch_file, *arguments]
    run = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if run.returncode != 0:
        raise AssertionError(run.stdout + run.stderr)
    return set(run.stdout.split())


def parameters(launch_file: str, *arguments: str) -> str:
    command = ["roslaunch", "--dump-params", "seater_bringup", launch_file, *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout


class LaunchFiles(unittest.TestCase):
    def test_simulation(self) -> None:
        self.assertEqual(nodes("sim.launch"), {"/sim", "/marker_detector", "/docking", "/safety_gate"})
        self.assertIn("/record", nodes("sim.launch", "record:=true"))

    def test_wheelchair_has_no_simulator(self) -> None:
        self.assertEqual(nodes("wheelchair.launch"), {"/marker_detector", "/docking", "/safety_gate"})
        self.assertNotIn("use_sim_time", parameters("wheelchair.launch"))

    def test_wheelchair_camera_mount_reaches_every_user(self) -> None:
        text = parameters("wheelchair.launch", "camera_x:=0.33", "camera_pitch:=0.12")
        for node in ("docking", "marker_detector"):
            self.assertIn(f"/{node}/chair/camera/x: 0.33", text)
            self.assertIn(f"/{node}/chair/camera/pitch: 0.12", text)

    def test_record_and_replay(self) -> None:
        self.assertEqual(nodes("record.launch", "bag:=x.bag"), {"/record"})
        self.assertEqual(nodes("replay.launch", "bag:=x.bag"), {"/marker_detector", "/docking", "/replay"})


if __name__ == "__main__":
    rostest.rosrun("seater_test", "launch_files", LaunchFiles, sys.argv)
