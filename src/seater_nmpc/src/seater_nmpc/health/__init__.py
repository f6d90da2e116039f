"""What the docking node says of each stage of the docking, in words with cause and remedy."""
