"""The adapter to ROS: topics in, hold-to-run and goals out."""
