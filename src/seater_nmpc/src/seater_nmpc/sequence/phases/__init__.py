"""What the chair does in each phase of a goal."""
