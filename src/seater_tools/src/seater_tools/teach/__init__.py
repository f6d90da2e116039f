"""The docked pose, from a chair that stands where it shall dock."""
