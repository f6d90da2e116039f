#!/usr/bin/env python3
"""What is done again comes out the same: a docking with the same seed to the last bit, recorded with its images or
without, alone or beside another run; and the poses of the images when the bag is replayed, at any rate."""

import csv
import json
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import rosbag
import rospy
import rostest

from seater_eval.docking.recording import read_recording
from seater_eval.ros.launch_process import LaunchProcess

# The images are the same bytes and the detector keeps no state between images, so the poses are equal up to the
# rounding of the CSV's way through odometry.
LARGEST_DIFFERENCE = 1e-9

OBSTACLE = "-1.2 1.0 0.3"  # a box beside the way


class Repeatable(unittest.TestCase):
    """All of it looks at one docking, with seed 7, that is recorded with its images. From near there are few."""

    start: str
    results: Path
    bag: Path

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.results, cls.start = Path(folder.name), rospy.get_param("/repeatable/start")
        cls.bag = cls.dock("live", seed=7, images="raw")

    @classmethod
    def dock(cls, name: str, seed: int, images: str) -> Path:
        """The bag of a docking."""
        results = cls.results / name
        options = ["--start", cls.start, "--obstacle", OBSTACLE, "--images", images, "--seed", str(seed)]
        command = ["rosrun", "seater_eval", "dock_run", *options, "--results", str(results)]
        run = subprocess.run(command, capture_output=True, text=True, timeout=500)
        assert run.returncode == 0, run.stdout + run.stderr
        return results / "run.bag"

    def test_same_seed_same_run(self) -> None:
        self.assert_same_as_first(self.dock("second", seed=7, images="none"))

    def test_replay(self) -> None:
        live = self.live_detections()
        self.assertGreater(len(live), 100)
        self.assert_same_detections(live, self.replay("fast", 0.0))
        self.assert_shadow_controller_ran(self.results / "fast")

    def assert_same_as_first(self, bag: Path) -> None:
        first, second = read_recording(self.bag), read_recording(bag)
        self.assert_same("true poses", first.truth, second.truth)
        self.assert_same("commands", first.commands, second.commands)

    def assert_same(self, what: str, first: np.ndarray, second: np.ndarray) -> None:
        # How long the simulation ran on after the result depends on the machine; all before must agree.
        length = min(len(first), len(second))
        self.assertGreater(length, 100, what)
        different = np.flatnonzero(np.any(first[:length] != second[:length], axis=1))
        self.assertEqual(len(different), 0, f"{what} differ first in row {different[:1]} of {length}")

    def live_detections(self) -> dict[str, tuple[int, float]]:
        """By stamp: number of markers, and the stated position sd of the dock (0 when not seen)."""
        found = {}
        with rosbag.Bag(str(self.bag)) as opened:
            for _, message, _ in opened.read_messages(topics=["/detections", "detections"]):
                sd = 0.0
                if message.dock:
                    sd = float(np.sqrt(sum(message.dock[0].pose.covariance[i * 7] for i in range(3))))
                found[f"{message.header.stamp.to_sec():.6f}"] = (len(message.markers), sd)
        return found

    def replay(self, name: str, rate: float) -> dict[str, list[str]]:
        """By stamp: the row of images.csv without its computing time."""
        results = self.results / name
        arguments = {"bag": self.bag, "results": results, "rate": rate}
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


class InMoreWays(Repeatable):
    """Of `./seater test --all`: beside another run, whose seed differs, and replayed at two rates."""

    def test_same_seed_same_run(self) -> None:
        with ThreadPoolExecutor(2) as pool:  # these two take each other's processor time
            beside = pool.submit(self.dock, "other", seed=8, images="none")
            self.assert_same_as_first(self.dock("second", seed=7, images="none"))
            other = read_recording(beside.result())
        first = read_recording(self.bag)
        length = min(len(first.truth), len(other.truth))
        self.assertFalse(np.array_equal(first.truth[:length], other.truth[:length]), "the seed changes nothing")

    def test_rates(self) -> None:
        fast, slow = self.replay("quick", 0.0), self.replay("slow", 3.0)
        self.assertEqual(list(fast), list(slow))
        self.assertEqual(fast, slow, "the rate changed what was found")


if __name__ == "__main__":
    cases = InMoreWays if rospy.get_param("/extensive", False) else Repeatable
    rostest.rosrun("seater_test", "repeatable", cases, sys.argv)
