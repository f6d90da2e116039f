"""Bars and pictures that all reports share."""
