"""Runs, reports and images."""
