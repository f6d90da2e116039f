"""What the dock says about the odometry."""
