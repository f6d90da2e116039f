"""Camera driver: images with the time of their exposure, from V4L2 and RealSense cameras."""
