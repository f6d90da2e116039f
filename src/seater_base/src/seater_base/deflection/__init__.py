"""Speeds to voltages, for chairs that obey nothing but an analogue joystick, and how their table is found."""
