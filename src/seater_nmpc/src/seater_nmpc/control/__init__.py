"""The controller: one command a cycle."""
