"""Laser scan and depth image of the world, for the obstacle node."""
