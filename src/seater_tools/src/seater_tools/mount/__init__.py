"""Where the camera sits on the chair and how the markers hang, from a drive in front of the dock."""
