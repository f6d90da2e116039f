"""A small bag for each docking: what was said shortly before it, and until it ended. ROS-free."""
