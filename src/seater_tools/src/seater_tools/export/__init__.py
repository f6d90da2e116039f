"""Bags as tables. ROS-free but for the bag itself."""
