"""The nodes round joystick and emergency stop."""
