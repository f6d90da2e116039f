"""Simulated drives, with chairs whose truth is known."""
