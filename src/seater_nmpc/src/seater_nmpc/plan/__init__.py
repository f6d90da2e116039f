"""Paths round obstacles to the dock."""
