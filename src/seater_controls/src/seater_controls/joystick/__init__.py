"""A joystick: events in, velocities out."""
