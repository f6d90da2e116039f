"""Dockings out of rendered images over random plants, chairs, docks, cameras and starts; no ROS."""
