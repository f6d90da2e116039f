"""Dockings among things that nobody told, without ROS and without images."""
