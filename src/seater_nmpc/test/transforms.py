"""TF without a master, for tests."""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped


class Transforms(tf2_ros.BufferCore):
    """The transforms without the listener, the waiting and the service of tf2_ros.Buffer."""

    def lookup_transform(self, target, source, time):
        return self.lookup_transform_core(target, source, time)

    def put(self, parent: str, child: str, pose, stamp: float) -> None:
        message = TransformStamped()
        message.header.frame_id, message.child_frame_id = parent, child
        message.header.stamp = rospy.Time.from_sec(stamp)
        message.transform.translation.x, message.transform.translation.y = pose[0], pose[1]
        message.transform.rotation.z, message.transform.rotation.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
        self.set_transform(message, "test")
