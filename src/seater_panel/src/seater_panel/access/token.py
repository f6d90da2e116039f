"""The secret that a page needs before it sees or does anything."""

from __future__ import annotations

import hmac
import os
import secrets
import stat
from pathlib import Path

BYTES = 24  # of randomness: cannot be guessed
SHORTEST = 20  # characters


class TokenError(ValueError):
    """The token's file cannot be used."""


def default_file() -> Path:
    """Where a program of this user keeps what has to last (XDG base directories)."""
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(base) / "seater" / "panel_token"


def load_or_make(path: Path) -> str:
    """The token in the file, which is made (mode 0600) when there is none.

    Raises:
        TokenError: others may read or write it, it belongs to somebody else, or it holds no token.
        OSError: it cannot be read or made.
    """
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    try:
        # O_EXCL: what is there already, a link too, is never written to.
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(secrets.token_urlsafe(BYTES) + "\n")
    except FileExistsError:
        pass
    with path.open() as file:
        status = os.fstat(file.fileno())
        if stat.S_IMODE(status.st_mode) & 0o077 or status.st_uid != os.getuid():
            raise TokenError(f"{path}: others may read it; remove it, a new one is made at the next start")
        token = file.read().strip()
    if len(token) < SHORTEST or not token.isascii() or not token.isprintable():
        raise TokenError(f"{path}: holds no token; remove it, a new one is made at the next start")
    return token


def matches(given: object, token: str) -> bool:
    """Whether it is the token; takes as long for a wrong one as for one that is nearly right."""
    return isinstance(given, str) and hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())
