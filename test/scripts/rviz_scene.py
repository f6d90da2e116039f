#!/usr/bin/env python3
"""What rviz is given to draw has the right frames, and lies where the simulated world truly is."""

import math
import sys

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PolygonStamped
from numpy.typing import NDArray
from seater_test.harness import DockingCase
from visualization_msgs.msg import Marker, MarkerArray

from seater_common.geometry import planar_pose, pose_matrix
from seater_common.messages import matrix_of_pose, matrix_of_transform
from seater_msgs.msg import MarkerDetectionArray
from seater_nmpc.ros.transforms import TransformBuffer

Array = NDArray[np.float64]

# [m] at 3 m from the markers, of which a single one of 100 mm is uncertain by 25 mm along the line of sight.
NEAR = 0.06
OBSTACLE = np.array([[-1.2, -1.0], [-0.9, -1.0], [-0.9, -0.7], [-1.2, -0.7]])  # of the launch file, in the dock frame
DOCK_NEAR = 0.02  # [m] the dock's own uncertainty from there


class RvizScene(DockingCase):
    def setUp(self) -> None:
        super().setUp()
        self.tf = TransformBuffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        self.heard: dict[str, MarkerArray] = {}
        self.detections: dict[int, MarkerDetectionArray] = {}
        self.footprint: PolygonStamped | None = None
        for topic in ("scene/dock", "scene/seen", "scene/obstacles"):
            rospy.Subscriber(topic, MarkerArray, lambda message, t=topic: self.heard.update({t: message}))
        rospy.Subscriber("scene/footprint", PolygonStamped, lambda message: setattr(self, "footprint", message))
        rospy.Subscriber("detections", MarkerDetectionArray, self._on_detections, queue_size=100)
        self.wait(lambda: len(self.heard) == 3 and self.footprint is not None, "all of the scene")
        self.wait(lambda: self.tf.can_transform("odom", "dock", rospy.Time(0)), "the dock's frame")
        self.T_dock_base = pose_matrix(self.truth[-1][1:4])  # the chair stands: no goal was given

    def test_the_footprint_is_the_chairs(self) -> None:
        assert self.footprint is not None
        self.assertEqual(self.footprint.header.frame_id, "base_link")
        corners = np.array([(p.x, p.y) for p in self.footprint.polygon.points])
        np.testing.assert_allclose(corners, self.chair.corners(), atol=1e-6)

    def test_the_dock_is_that_of_its_file(self) -> None:
        found = self.heard["scene/dock"].markers
        self.assertEqual({marker.header.frame_id for marker in found}, {"dock"})
        self.assertTrue(all(marker.frame_locked for marker in found))
        prints = of(found, "prints")
        for marker, expected in zip(prints, self.dock.markers, strict=True):
            np.testing.assert_allclose(matrix_of_pose(marker.pose), expected.T_dock_marker(), atol=1e-6)
            self.assertEqual(marker.scale.x, expected.size)
        back = max(of(found, "bay"), key=lambda marker: marker.pose.position.x)
        self.assertAlmostEqual(back.pose.position.x - back.scale.x / 2, self.dock.bay.back_wall_x)

    def test_what_is_seen_lies_where_it_truly_is(self) -> None:
        seen = self.heard["scene/seen"].markers
        self.assertEqual({marker.header.frame_id for marker in seen}, {"base_link"})
        self.assertEqual(seen[0].action, Marker.DELETEALL)
        prints = of(seen, "markers")
        for marker, expected in zip(prints, self.dock.markers, strict=True):
            T = self.T_dock_base @ matrix_of_pose(marker.pose)
            np.testing.assert_allclose(T[:3, 3], expected.position, atol=NEAR)
            self.assertGreater(T[:3, 2] @ expected.T_dock_marker()[:3, 2], 0.9)  # out of the paper
        arrow = next(marker for marker in of(seen, "candidates") if marker.type == Marker.ARROW)
        pose = planar_pose(self.T_dock_base @ matrix_of_pose(arrow.pose))
        np.testing.assert_allclose(pose, np.zeros(3), atol=DOCK_NEAR)

    def test_ellipsoids_are_the_covariances_of_perception(self) -> None:
        seen = self.heard["scene/seen"].markers
        self.wait(lambda: seen[0].header.stamp.to_nsec() in self.detections, "the detections of that image")
        message = self.detections[seen[0].header.stamp.to_nsec()]
        ellipsoids = of(seen, "covariances")
        self.assertEqual(len(ellipsoids), len(message.markers))
        for ellipsoid, marker in zip(ellipsoids, message.markers, strict=True):
            covariance = np.reshape(marker.pose.covariance, (6, 6))[:3, :3]
            T = self.chair.camera.T_base_optical()[:3, :3].T @ matrix_of_pose(ellipsoid.pose)[:3, :3]
            axes = np.array([ellipsoid.scale.x, ellipsoid.scale.y, ellipsoid.scale.z]) / 4.0  # two sigma to both sides
            np.testing.assert_allclose(T @ np.diag(axes**2) @ T.T, covariance, atol=0.3e-3**2 + 0.01 * covariance.max())

    def test_obstacles_lie_where_they_truly_are(self) -> None:
        outline = of(self.heard["scene/obstacles"].markers, "outlines")[0]
        header = outline.header
        T = matrix_of_transform(self.tf.lookup_transform("odom", header.frame_id, header.stamp).transform)
        T_odom_base = matrix_of_transform(self.tf.lookup_transform("odom", "base_link", rospy.Time(0)).transform)
        corners = np.array([(p.x, p.y, p.z, 1.0) for p in outline.points])
        found = (corners @ (self.T_dock_base @ np.linalg.inv(T_odom_base) @ T).T)[:, :2]
        np.testing.assert_allclose(found[0], found[-1])  # closed
        self.assertTrue(all(min(math.dist(a, b) for b in found) < DOCK_NEAR for a in OBSTACLE))

    def _on_detections(self, message: MarkerDetectionArray) -> None:
        self.detections[message.header.stamp.to_nsec()] = message


def of(markers: list[Marker], name: str) -> list[Marker]:
    return [marker for marker in markers if marker.ns == name]


if __name__ == "__main__":
    rostest.rosrun("seater_test", "rviz_scene", RvizScene, sys.argv)
