"""What talks to ROS."""
