"""The scripted drive."""
