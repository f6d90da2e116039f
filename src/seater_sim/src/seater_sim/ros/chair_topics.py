"""What the chair and its base tell: odometry, contact, and for the evaluation how things really are."""

from __future__ import annotations

import rospy
import tf2_ros
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import Bool, UInt32

from seater_common.geometry import CameraMount
from seater_msgs.msg import ObstacleArray
from seater_sim.chair.interface import OdometrySample
from seater_sim.loop.simulator import Truth
from seater_sim.ranging.sensor import RangeSensor
from seater_sim.ranging.taken import SimulatedRange
from seater_sim.ros import messages
from seater_sim.settings import SCAN, Obstacle


def publisher(topic: str, kind: type, latch: bool = False) -> rospy.Publisher:
    """With a long queue: in lock-step nobody falls behind, and a recorder shall not lose anything."""
    return rospy.Publisher(topic, kind, queue_size=100, latch=latch, tcp_nodelay=True)


class ChairTopics:
    """Publishers. Latched, so that who comes late still learns where the chair is while it stands."""

    def __init__(self, obstacles: list[Obstacle]) -> None:
        """`obstacles`: those that are told; none: no such topic."""
        self._told = obstacles
        self.odometry = publisher("odom", Odometry, latch=True)
        self.obstacles = publisher("obstacles", ObstacleArray, latch=True) if obstacles else None
        self._truth = publisher("ground_truth", Odometry, latch=True)
        self._contact = publisher("charging_contact", Bool, latch=True)
        self._collisions = publisher("collisions", UInt32, latch=True)
        self._static = tf2_ros.StaticTransformBroadcaster()
        self._transforms = tf2_ros.TransformBroadcaster()

    def publish_static(self, mount: CameraMount | None, sensor: RangeSensor | None, time_ns: int) -> None:
        """Where camera and laser scanner sit, as the other nodes are told; None: nothing is told."""
        transforms = [] if mount is None else messages.camera_transforms(mount, time_ns)
        if sensor is not None and sensor.kind == SCAN:
            transforms.append(messages.laser_transform(sensor, time_ns))
        self._static.sendTransform(transforms)

    def publish_odometry(self, sample: OdometrySample) -> None:
        """odom and its transform; the transform first, so that it is there for who acts on odom."""
        message = messages.odometry_message(sample)
        self._transforms.sendTransform(messages.odometry_transform(message))
        self.odometry.publish(message)

    def publish_truth(self, truth: Truth) -> None:
        """True pose, for the evaluation."""
        self._truth.publish(messages.truth_message(truth))

    def publish_contact(self, closed: bool) -> None:
        """Charging contact."""
        self._contact.publish(Bool(closed))

    def publish_obstacles(self, time_ns: int) -> None:
        """What stands in the way, if it is told."""
        if self.obstacles is not None:
            self.obstacles.publish(messages.obstacles_message(self._told, time_ns))

    def publish_collisions(self, count: int) -> None:
        """How often the chair ran into something."""
        if count > 0:
            rospy.logerr("Collision %d: the chair runs into a wall or an obstacle.", count)
        self._collisions.publish(UInt32(count))


class RangeTopics:
    """What the sensor of obstacles sends; computed only when somebody listens."""

    def __init__(self, kind: str) -> None:
        """`kind`: scan or depth."""
        self.output = publisher("scan", LaserScan) if kind == SCAN else publisher("depth/image", Image)
        self._info = None if kind == SCAN else publisher("depth/camera_info", CameraInfo)

    def publish(self, taken: SimulatedRange) -> bool:
        """True when somebody listens."""
        if self._info is not None:
            self._info.publish(messages.depth_info_message(taken))
        if self.output.get_num_connections() == 0:
            return False
        self.output.publish(messages.range_message(taken))
        return True
