"""Boards that a lens is calibrated with."""
