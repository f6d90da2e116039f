"""Solvers of the optimal control problem behind one interface."""
