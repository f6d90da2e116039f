"""What a check says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Verdict:
    """One line. `ok` None: it could not be judged, `what` says why; that is no fault."""

    name: str
    ok: bool | None
    what: str  # with numbers
    remedy: str = ""  # what to do, where it is wrong


def good(name: str, what: str) -> Verdict:
    """In order."""
    return Verdict(name, True, what)


def wrong(name: str, what: str, remedy: str) -> Verdict:
    """A fault of the installation."""
    return Verdict(name, False, what, remedy)


def unknown(name: str, why: str) -> Verdict:
    """Not judged."""
    return Verdict(name, None, why)
