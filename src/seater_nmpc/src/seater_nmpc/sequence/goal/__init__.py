"""What a goal is about: its phases and results, how long it may take, how far it has come."""
