"""Simulated time in whole nanoseconds."""

from __future__ import annotations

NANOSECONDS = 1_000_000_000


def to_ns(seconds: float) -> int:
    """Nanoseconds, rounded: time is counted in whole nanoseconds so that it never drifts."""
    return round(seconds * NANOSECONDS)
