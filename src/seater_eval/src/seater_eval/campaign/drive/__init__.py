"""One docking out of rendered images, in lock-step and without ROS, and what is measured of it."""
