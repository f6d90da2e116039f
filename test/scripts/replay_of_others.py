#!/usr/bin/env python3
"""Bags that others record: without odometry, compressed images only, camera_info of other stamps, a dock of markers."""

import csv
import json
import sys
import tempfile
import unittest
from pathlib import Path

import cv2
import numpy as np
import rosbag
import rospy
import rostest
import yaml
from sensor_msgs.msg import CameraInfo, CompressedImage

from seater_eval.ros.launch_process import LaunchProcess

F, SIDE, SIZE = 640.0, 128, 0.1  # [px], [px], [m]
AHEAD, AT = 0.45, (576, 296)  # the camera is so far before base_link [m]; first pixel of the print, in the middle
DISTANCE = F * SIZE / SIDE  # 0.5 m
IMAGES, OFFSET = 5, 0.01  # of camera_info from images [s]


def picture() -> bytes:
    image = np.full((720, 1280), 215, np.uint8)
    black = cv2.aruco.drawMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 7, SIDE) < 128
    image[AT[1] : AT[1] + SIDE, AT[0] : AT[0] + SIDE] = np.where(black, 40, 215)
    return cv2.imencode(".png", cv2.GaussianBlur(image, (0, 0), 0.8))[1].tobytes()


def write_bag(path: Path) -> None:
    K = [F, 0.0, 639.5, 0.0, F, 359.5, 0.0, 0.0, 1.0]
    info = CameraInfo(width=1280, height=720, K=K, distortion_model="Inverse Brown Conrady", D=[0.0] * 5)
    image = CompressedImage(format="png", data=picture())
    info.header.frame_id = image.header.frame_id = "front_camera_optical"
    with rosbag.Bag(str(path), "w") as bag:
        for i in range(IMAGES):
            time = rospy.Time.from_sec(100.0 + 0.1 * i)
            image.header.stamp, info.header.stamp = time, time + rospy.Duration.from_sec(OFFSET)
            bag.write("/front/image_raw/compressed", image, time)
            bag.write("/front/camera_info", info, info.header.stamp)


class ReplayOfOthers(unittest.TestCase):
    def replay(self, folder: Path, **more: object) -> tuple[str, Path]:
        """Everything that it says, and its results."""
        write_bag(folder / "others.bag")
        marker = {"id": 7, "size": SIZE, "position": [0.0, 0.0, 0.7], "normal_yaw": 3.14159265}
        (folder / "markers.yaml").write_text(yaml.safe_dump({"dictionary": "DICT_4X4_50", "markers": [marker]}))
        arguments = {"bag": folder / "others.bag", "results": folder / "results", "dock_file": folder / "markers.yaml"}
        arguments |= {"image": "front/image_raw", "camera_info": "front/camera_info", "controller": "false", **more}
        log = folder / "launch.log"
        with LaunchProcess("seater_bringup", "replay.launch", arguments, log) as launch:
            self.assertTrue(launch.wait(60.0), launch.last_lines())
        return log.read_text(), folder / "results"

    def test_perception_alone(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            said, results = self.replay(Path(folder), match_camera_info="nearest")
            self.assertIn("images are decoded here", said)
            self.assertIn("camera_info of the nearest stamp was taken: up to 10.0 ms from its image", said)
            self.assertNotIn("has died", said, "it ended well, and roslaunch says otherwise")
            summary = json.loads((results / "summary.json").read_text())
            self.assertEqual(summary["dock_detected"], IMAGES)
            self.assertEqual(summary["frame"], "base_link")
            with (results / "images.csv").open() as file:
                rows = list(csv.DictReader(file))
            for row in rows:
                self.assertAlmostEqual(float(row["dock_x"]), AHEAD + DISTANCE, delta=0.005)
                self.assertAlmostEqual(float(row["dock_y"]), 0.0, delta=0.005)


class InMoreWays(ReplayOfOthers):
    """Of `./seater test --all`: the launch file says so. test_bag_input.py asks the same without processes."""

    def test_what_prevents_it_is_named(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            said, results = self.replay(Path(folder))
            lines = [line for line in said.splitlines() if "nothing was processed" in line]
            self.assertTrue(lines, said)
            self.assertIn(
                f"none of {IMAGES} images has a camera_info of its own stamp; the nearest is 10.0 ms", lines[0]
            )
            self.assertFalse((results / "summary.json").exists())
            self.assertRegex(said, r"process has died .*exit code 1", "a replay of nothing has to fail")


if __name__ == "__main__":
    cases = InMoreWays if rospy.get_param("/extensive", False) else ReplayOfOthers
    rostest.rosrun("seater_test", "replay_of_others", cases, sys.argv)
