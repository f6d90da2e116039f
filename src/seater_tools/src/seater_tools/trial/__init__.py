"""A drive in front of a simulated dock whose truth is known."""
