"""Files that are there completely or not at all."""

from __future__ import annotations

import datetime
import os
from pathlib import Path


def write_whole(path: Path, content: bytes, overwrite: bool) -> None:
    """Beside its place first, then moved there: whoever reads meanwhile, or after a power cut, finds all or none of it.

    Raises:
        FileExistsError: it is there and must not be overwritten.
        OSError: it cannot be written.
    """
    if path.exists() and not overwrite:
        raise FileExistsError(f"{path} exists already; --force overwrites it")
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def replace_kept(text: str, target: Path, now: datetime.datetime) -> list[Path]:
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
