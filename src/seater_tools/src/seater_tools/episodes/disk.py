"""The folder of the bags: never more than so many megabytes, the oldest go first. Files of others stay."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

OURS = re.compile(r"^\d{8}T\d{6}Z_(un)?dock_\w+\.bag$")
PART = ".part"  # behind the name of a bag that is not complete
LEAST_FREE = 200_000_000  # [bytes] that stay free on the disk for others


def bags(folder: Path) -> list[Path]:
    """The oldest first: names begin with the time."""
    return sorted(path for path in folder.glob("*.bag") if OURS.match(path.name))


def make_room(folder: Path, most: int) -> list[Path]:
    """Removes the oldest bags until there are no more than `most` bytes, but never the newest one; what was removed.

    Raises OSError.
    """
    found = bags(folder)
    sizes = {path: path.stat().st_size for path in found}
    removed = []
    for path in found[:-1]:
        if sum(sizes.values()) <= most:
            break
        path.unlink()
        del sizes[path]
        removed.append(path)
    return removed


def remove_parts(folder: Path) -> None:
    """Of bags that a power cut has ended. Raises OSError."""
    for path in folder.glob(f"*.bag{PART}"):
        if OURS.match(path.name.removesuffix(PART)):
            path.unlink()


def has_room(folder: Path, size: int) -> bool:
    """Whether a bag of so many bytes leaves enough for others."""
    return shutil.disk_usage(folder).free - size >= LEAST_FREE
