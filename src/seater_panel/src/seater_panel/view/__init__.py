"""What the panel shows, out of what was heard last. No ROS, no web."""
