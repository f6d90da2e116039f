"""Checks of an installation: from observations, which somebody else has gathered, to verdicts."""
