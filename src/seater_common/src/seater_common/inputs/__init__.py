"""What nodes want to know of their inputs beside the messages."""
