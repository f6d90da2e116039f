"""When an image was taken, by ROS time."""
