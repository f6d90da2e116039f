"""TF that survives every stamp: tf2's Python binding ends the whole process at those that it cannot represent."""

from __future__ import annotations

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

_WARNING_PERIOD = 5.0  # [s]
_END_OF_TIME = 2**31 - 1  # [s] from here on tf2_py crashes, or lets a C++ exception out


class TransformBuffer(tf2_ros.Buffer):
    """What a TransformListener fills; stamps of 2038 and later are refused."""

    def lookup_transform(
        self, target_frame: str, source_frame: str, time: rospy.Time, timeout: rospy.Duration | None = None
    ) -> TransformStamped:
        """The pose of the source frame in the target frame at `time`.

        Raises:
            tf2_ros.TransformException: unknown, or a time that TF cannot represent.
        """
        if not _usable(time):
            raise tf2_ros.ExtrapolationException(f"no transform at {time.secs} s, which TF cannot represent")
        return super().lookup_transform(target_frame, source_frame, time, timeout or rospy.Duration(0))

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """Take a transform from /tf, or drop it with a warning."""
        if _usable(transform.header.stamp):
            super().set_transform(transform, authority)
        else:
            text = "transform of %r dropped: its stamp of %d s is not one that TF can represent"
            rospy.logwarn_throttle(_WARNING_PERIOD, text, transform.child_frame_id, transform.header.stamp.secs)

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """The same from /tf_static, where the stamp does not count."""
        transform.header.stamp = rospy.Time()
        super().set_transform_static(transform, authority)


def _usable(time: rospy.Time) -> bool:
    return bool(time.secs < _END_OF_TIME)
