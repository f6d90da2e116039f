"""What talks to ROS: running launch files, the action client, replay."""
