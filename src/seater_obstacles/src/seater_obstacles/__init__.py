"""Obstacles that nobody told: from scans, clouds and depth images to outlines and points to keep clear of."""
