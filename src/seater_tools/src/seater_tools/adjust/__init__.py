"""Robust sparse least squares with standard deviations."""
