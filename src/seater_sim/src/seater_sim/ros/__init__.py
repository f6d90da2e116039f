"""The ROS shell of the simulator; the core beside it knows no ROS."""
