"""Whether commands, odometry, images and installation agree."""
