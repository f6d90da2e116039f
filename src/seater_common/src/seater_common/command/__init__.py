"""What the commands for people have in common."""
