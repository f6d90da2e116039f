"""What a person has in hand: a joystick by evdev, and an emergency stop at a contact."""
