"""Files that are there completely or not at all."""

from __future__ import annotations

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
