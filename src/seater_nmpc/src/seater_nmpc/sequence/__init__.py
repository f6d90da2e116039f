"""Docking and undocking from the goal to the result."""
