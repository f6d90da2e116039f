#!/usr/bin/env python3
"""A docking is recorded with its images; replaying the bag gives the poses of the live run, at any rate."""

import csv
import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
import rosbag
import rostest

from seater_eval.ros.launch_process import LaunchProcess

# The images are the same bytes and the detector keeps no state between images, so the poses are equal up to the
# rounding of the CSV's way through odometry.
LARGEST_DIFFERENCE = 1e-9

START, OBSTACLE = "-1.0 0.05 0", "-1.2 1.0 0.3"  # near, so that few images say all; a box beside the way


class ReplayEqualsLive(unittest.TestCase):
    def test_replay(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            results = Path(folder)
            bag = self.record(results / "live")
            live = self.live_detections(bag)
            self.assertGreater(len(live), 100)
            fast = self.replay(bag, results / "fast", 0.0)
            slow = self.replay(bag, results / "slow", 3.0)
            self.assertEqual(list(fast), list(slow))
            self.assertEqual(fast, slow, "the rate changed what was found")
            self.assert_same_detections(live, fast)
            self.assert_shadow_controller_ran(results / "fast")

    def record(self, results: Path) -> Path:
        command = ["rosrun", "seater_eval", "dock_run", "--images", "raw", "--results", str(results)]
        run = subprocess.run(
            [*command, "--start", START, "--obstacle", OBSTACLE], capture_output=True, text=True, timeout=500
        )
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        return results / "run.bag"

    def live_detections(self, bag: Path) -> dict[str, tuple[int, float]]:
        """By stamp: number of markers, and the stated position sd of the dock (0 when not seen)."""
        found = {}
        with rosbag.Bag(str(bag)) as opened:
            for _, message, _ in opened.read_messages(topics=["/detections", "detections"]):
                sd = 0.0
                if message.dock:
                    sd = float(np.sqrt(sum(message.dock[0].pose.covariance[i * 7] for i in range(3))))
                found[f"{message.header.stamp.to_sec():.6f}"] = (len(message.markers), sd)
        return found

    def replay(self, bag: Path, results: Path, rate: float) -> dict[str, list[str]]:
        """By stamp: the row of images.csv without its computing time."""
        arguments = {"bag": bag, "results": results, "rate": rate}
        with LaunchProcess("seater_bringup", "replay.launch", arguments, results / "log" / "launch.log") as launch:
            ended = launch.wait(300.0)
        self.assertTrue(ended and (results / "summary.json").exists(), launch.last_lines())
        with (results / "images.csv").open() as file:
            rows = list(csv.DictReader(file))
        return {f"{float(r['stamp']):.6f}": [v for k, v in r.items() if k != "processing_ms"] for r in rows}

    def assert_same_detections(self, live: dict[str, tuple[int, float]], replayed: dict[str, list[str]]) -> None:
        # The recorder may have started an image late or ended one early; all that both have must agree.
        common = sorted(set(live) & set(replayed))
        self.assertGreaterEqual(len(common), len(live) - 3)
        for stamp in common:
            markers, sd = live[stamp]
            row = replayed[stamp]
            self.assertEqual(int(row[1]), markers, f"image {stamp}")
            self.assertAlmostEqual(float(row[6] or 0.0), sd, delta=LARGEST_DIFFERENCE, msg=f"image {stamp}")

    def assert_shadow_controller_ran(self, results: Path) -> None:
        summary = json.loads((results / "summary.json").read_text())
        self.assertGreater(summary["detection_rate"], 0.95)
        self.assertEqual(summary["obstacle_messages"], 1, "the docking node did not hear of the obstacle in the bag")
        self.assertGreater(summary["shadow_controller"]["cycles"], 50)
        self.assertGreater(summary["shadow_controller"]["v_max"], 0.05)


if __name__ == "__main__":
    rostest.rosrun("seater_test", "replay_equals_live", ReplayEqualsLive, sys.argv)
