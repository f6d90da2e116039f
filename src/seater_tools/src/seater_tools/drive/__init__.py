"""A drive in front of the dock: what the camera saw of the markers and what the odometry measured."""
