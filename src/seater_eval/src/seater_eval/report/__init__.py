"""Bars and images that all reports share."""
