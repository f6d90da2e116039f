"""ROS-free simulation of the chair and its camera: plant, odometry, world, images, charging contact."""
