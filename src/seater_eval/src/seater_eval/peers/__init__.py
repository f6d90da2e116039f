"""Marker detectors of other people, from PyPI, each in a process of its own."""
