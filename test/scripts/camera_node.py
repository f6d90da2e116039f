#!/usr/bin/env python3
"""The camera node plays a recorded stream: every image once, with camera_info, its time and a word about the end."""

import subprocess
import sys
import tempfile
import threading
import time
import unittest
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import rospkg
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import CameraInfo, Image

from seater_common.params import read_yaml

FRAMES, RATE = 50, 20
CONFIG = Path(rospkg.RosPack().get_path("seater_config"))
WORDS = ["rosrun", "seater_camera", "camera_node", "__name:=camera"]


def wait(condition: Callable[[], bool], seconds: float = 20.0) -> bool:
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.05)
    return condition()


class CameraNode(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        for n in range(FRAMES):
            image = np.random.default_rng(n).integers(0, 255, (480, 640), dtype=np.uint8)
            cv2.imwrite(f"{self.folder.name}/{n:03d}.png", image)
        settings = read_yaml(CONFIG / "camera.yaml")
        settings["device"] = self.folder.name
        settings["exposure"]["mode"] = "device"
        settings["format"] |= {"width": 640, "height": 480, "rate": RATE}
        rospy.set_param("/camera/settings", settings)
        rospy.set_param("/camera/source", "recorded")
        rospy.set_param("/camera/calibration", read_yaml(CONFIG / "cameras" / "d455_640x480.yaml"))

    def run_once(self) -> subprocess.CompletedProcess[str]:
        return subprocess.run(WORDS, capture_output=True, text=True, timeout=30)

    def test_a_recorded_stream(self) -> None:
        images: list[tuple[float, float]] = []  # stamp, arrival
        infos: list[CameraInfo] = []
        said: list[str] = []
        lock = threading.Lock()

        def on_image(message: Image) -> None:
            with lock:
                self.assertEqual((message.width, message.height, message.encoding), (640, 480, "mono8"))
                images.append((message.header.stamp.to_sec(), time.time()))

        rospy.Subscriber("image_raw", Image, on_image, queue_size=100)
        rospy.Subscriber("camera_info", CameraInfo, infos.append, queue_size=100)
        names = "camera: camera"
        rospy.Subscriber(
            "/diagnostics",
            DiagnosticArray,
            lambda m: said.extend(s.message for s in m.status if s.name == names),
        )
        process = subprocess.Popen(WORDS)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        self.assertTrue(wait(lambda: any("has ended after" in text for text in said)), said)
        # The first ones go out before we are connected.
        self.assertGreater(len(images), FRAMES // 2)
        self.assertIn("working", said)
        stamps, arrivals = np.array(images).T
        self.assertTrue(np.all(np.diff(stamps) > 0.0))
        self.assertTrue(np.all(stamps <= arrivals))
        self.assertAlmostEqual(float(np.median(np.diff(stamps))), 1.0 / RATE, delta=0.005)
        # camera_info may have been connected after the images.
        told = {info.header.stamp.to_sec() for info in infos}
        self.assertLessEqual(set(stamps[stamps >= min(told)]), told)
        self.assertEqual((infos[0].width, infos[0].header.frame_id), (640, "camera_color_optical_frame"))

    def test_a_calibration_of_another_size_stops_the_start(self) -> None:
        rospy.set_param("/camera/calibration", read_yaml(CONFIG / "cameras" / "d455.yaml"))
        ended = self.run_once()
        self.assertEqual(ended.returncode, 1)
        self.assertIn("is of 1280 x 720 pixels", ended.stdout + ended.stderr)
        self.assertIn("640 x 480", ended.stdout + ended.stderr)

    def test_simulated_time_is_refused(self) -> None:
        rospy.set_param("/use_sim_time", True)
        self.addCleanup(rospy.set_param, "/use_sim_time", False)
        ended = self.run_once()
        self.assertEqual(ended.returncode, 1)
        self.assertIn("use_sim_time", ended.stdout + ended.stderr)


if __name__ == "__main__":
    rospy.init_node("camera_node_test")
    rostest.rosrun("seater_test", "camera_node", CameraNode, sys.argv)
