"""Hold-to-run of the panel: which page holds, and what the chair is told because of it. No ROS, no web."""
