"""A chair at rest near the dock: whether it stands, what is to be done with it, the small move, the verification."""
