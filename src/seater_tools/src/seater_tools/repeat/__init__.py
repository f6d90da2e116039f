"""Docking and undocking again and again on the running chair: how well it repeats itself."""
