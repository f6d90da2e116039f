"""What is known of the chair's motion and of the dock's pose, from odometry and detections."""
