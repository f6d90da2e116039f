"""What arrives, worked by one thread in the order of its arrival."""
