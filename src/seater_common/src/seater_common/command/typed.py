"""Commands as the person who reads of them types them."""

from __future__ import annotations

import os

FRONT_DOOR = "./seater "  # as texts of the code name it


def as_typed(text: str) -> str:
    """`./seater` beside the sources; `seater` where the Debian package is installed, whose command says so."""
    return text.replace(FRONT_DOOR, os.environ.get("SEATER_COMMAND", FRONT_DOOR.strip()) + " ")
