"""The new dock file in its place, the old one kept."""

from __future__ import annotations

import datetime
from pathlib import Path

from seater_tools.files import write_whole


def store(text: str, target: Path, now: datetime.datetime) -> list[Path]:
    """Writes the text as `target`; one that is there stays beside it, with the time in its name. Files written.

    Raises OSError: nothing is changed then.
    """
    written = []
    if target.exists():
        old = target.with_name(f"{target.name}.{now.astimezone(datetime.UTC).strftime('%Y%m%dT%H%M%SZ')}")
        write_whole(old, target.read_bytes(), overwrite=False)
        written.append(old)
    write_whole(target, text.encode(), overwrite=True)
    return [target, *written]
