"""Images in folders, each once, and the dictionaries that each may not show."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.marker_family import marker_family, predefined_names
from seater_common.params import ParameterError
from seater_eval.photographs.truth import FILE, load_folders

Image = NDArray[np.uint8]
SUFFIXES = (".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff", ".webp")
SMALLEST = 64  # [px] of an image's shorter side: icons have no room for a marker and its surroundings
ALL = "all"


@dataclass(frozen=True, kw_only=True)
class Negative:
    """One image file, and the dictionaries whose markers it does not show."""

    path: Path
    dictionaries: tuple[str, ...]


def negatives_in(folders: Sequence[Path], dictionaries: Sequence[str], without: Sequence[str]) -> list[Negative]:
    """All image files below the folders, by name, the same bytes once; not those whose path matches a pattern of
    `without`. Beside a truth.json an image shows the markers that it lists: dictionaries with one of their codes are
    left out for that folder. Raises ParameterError."""
    seen: set[bytes] = set()
    found = []
    for folder in folders:
        if not folder.is_dir():
            raise ParameterError(f"FOLDER: {folder} is no folder")
        others: dict[Path, tuple[str, ...]] = {}
        for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES and p.is_file()):
            if any(fnmatch(str(path), pattern) for pattern in without):
                continue
            digest = hashlib.sha256(path.read_bytes()).digest()
            if digest in seen:
                continue
            seen.add(digest)
            if path.parent not in others:
                others[path.parent] = _not_shown(path.parent, dictionaries)
            found.append(Negative(path=path, dictionaries=others[path.parent]))
    return found


def names_of(asked: Iterable[str]) -> tuple[str, ...]:
    """Names of dictionaries; ALL: all that OpenCV has. Raises ParameterError."""
    names: list[str] = []
    for name in asked:
        names += predefined_names() if name == ALL else [name]
    for name in names:
        try:
            marker_family(name)
        except (OSError, ValueError) as error:
            raise ParameterError(f"--dictionary: {error}") from error
    return tuple(dict.fromkeys(names))


def _not_shown(folder: Path, dictionaries: Sequence[str]) -> tuple[str, ...]:
    if not (folder / FILE).is_file():
        return tuple(dictionaries)
    (shown,) = load_folders(folder)
    ids = {marker.id for photograph in shown.photographs for marker in photograph.markers}
    # What no detector had seen is not in the list, but of the same dictionary.
    ids |= {int(i) for i in json.loads((folder / FILE).read_text()).get("board_marker_centers", {})}
    return tuple(name for name in dictionaries if not has_one_of(name, shown.dictionary, ids))


def has_one_of(dictionary: str, other: str, ids: Iterable[int]) -> bool:
    """Whether `dictionary` has a code that is one of `other`'s, turned by any quarter."""
    codes = {_cells(dictionary, i).tobytes() for i in range(len(marker_family(dictionary).codes))}
    return any(np.rot90(_cells(other, i), turn).tobytes() in codes for i in ids for turn in range(4))


def _cells(dictionary: str, marker_id: int) -> NDArray[np.uint8]:
    return np.ascontiguousarray(marker_family(dictionary).print_of(marker_id), dtype=np.uint8)


def read_grey(path: Path, longest: int) -> Image | None:
    """Grey levels of 8 bits, averaged down to `longest` px where the image is longer; None: no image, or too small."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None or min(image.shape) < SMALLEST:
        return None
    scale = longest / max(image.shape)
    if scale < 1.0:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(image, dtype=np.uint8)
