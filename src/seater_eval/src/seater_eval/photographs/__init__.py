"""Photographs of printed markers whose places are known: what detectors find in them, and how exactly."""
