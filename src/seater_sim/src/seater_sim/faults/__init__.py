"""Faults of the simulated chair and its camera, injected while it runs freely; no ROS here."""
