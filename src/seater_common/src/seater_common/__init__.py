"""What several ROS-free cores share: planar poses, typed parameters, the chair and the dock."""
