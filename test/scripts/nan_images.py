#!/usr/bin/env python3
"""The camera sends images full of NaN: the chair does not move, and the action says that no dock was found."""

import sys

import rospy
import rostest
from seater_test.harness import DockingCase
from sensor_msgs.msg import Image

from seater_msgs.msg import DockResult, MarkerDetectionArray


class NanImages(DockingCase):
    def test_no_motion(self) -> None:
        images: list[str] = []
        detections: list[MarkerDetectionArray] = []
        rospy.Subscriber("camera/color/image_raw", Image, lambda m: images.append(m.encoding), queue_size=10)
        rospy.Subscriber("detections", MarkerDetectionArray, detections.append, queue_size=10)
        self.start()
        result = self.result()
        self.assertEqual(result.result_code, DockResult.FAILED_TO_DETECT_DOCK, result.result_text)
        self.assertGreater(len(images), 10)
        self.assertEqual(detections, [], "perception made something of an image without content")
        self.assertTrue(all(v == 0.0 and omega == 0.0 for _, v, omega in self.commands))
        self.assertEqual(self.truth[0][1:4], self.truth[-1][1:4])


if __name__ == "__main__":
    rostest.rosrun("seater_test", "nan_images", NanImages, sys.argv)
