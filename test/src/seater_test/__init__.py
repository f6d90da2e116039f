"""What the rostests share."""
