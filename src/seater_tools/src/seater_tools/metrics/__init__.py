"""Metrics for Prometheus. ROS-free."""
