"""Identification of a chair: delay, lag, gains, deadbands, ramp and odometry from a drive."""
