"""Runs, reports and pictures."""
