"""Folders of photographs with `truth.json`: which markers are there, and where on a flat board they are.

{"dictionary": "DICT_4X4_50",
 "images": {"00.jpg": {"width": 640, "height": 480, "K": [9 numbers], "D": [5 or 8 numbers],
                       "markers": [{"id": 3, "center": [u, v], "side": 41.5}, ...]}, ...},
 "board_marker_centers": {"3": [2.5, 0.5], ...},     optional: centres on a flat board, in any unit
 "board_marker_side": 0.7333}                        optional: of the black squares, in the same unit
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_common.params import ParameterError

Array = NDArray[np.float64]
FILE = "truth.json"


@dataclass(frozen=True, kw_only=True)
class KnownMarker:
    """A marker that is really in a photograph."""

    id: int
    center: Array  # (2,) [px]
    side: float  # [px]


@dataclass(frozen=True, kw_only=True)
class Photograph:
    """One image with its camera (K (3, 3), D as of plumb_bob or rational_polynomial) and its markers."""

    path: Path
    width: int
    height: int
    K: Array
    D: Array
    markers: tuple[KnownMarker, ...]


@dataclass(frozen=True, kw_only=True)
class PhotographFolder:
    """Photographs of one kind. `board`: id -> (2,), the marker's centre on the flat board; empty: there is none."""

    name: str
    dictionary: str
    photographs: tuple[Photograph, ...]
    board: dict[int, Array] = field(default_factory=dict)
    board_marker_side: float | None = None


def load_folders(path: str | Path) -> list[PhotographFolder]:
    """The folder itself, or those in it, that hold a truth.json; by name. Raises ParameterError naming file and key."""
    path = Path(path)
    files = [path / FILE] if (path / FILE).is_file() else sorted(path.glob(f"*/{FILE}"))
    if not files:
        raise ParameterError(f"photographs: no {FILE} in {path} or in the folders in it")
    return [_load(file) for file in files]


def _load(file: Path) -> PhotographFolder:
    try:
        values = json.loads(file.read_text())
        photographs = tuple(_photograph(file.parent / name, v) for name, v in sorted(values["images"].items()))
        board = {
            int(i): np.asarray(at, dtype=float).reshape(2) for i, at in values.get("board_marker_centers", {}).items()
        }
        side = values.get("board_marker_side")
        return PhotographFolder(
            name=file.parent.name,
            dictionary=str(values["dictionary"]),
            photographs=photographs,
            board=board,
            board_marker_side=None if side is None else float(side),
        )
    except KeyError as error:
        raise ParameterError(f"{file}: key {error} is missing") from error
    except (OSError, TypeError, ValueError, AttributeError) as error:
        raise ParameterError(f"{file}: {error}") from error


def _photograph(path: Path, values: dict[str, Any]) -> Photograph:
    if not path.is_file():
        raise ValueError(f"images: there is no file {path.name}")
    markers = tuple(
        KnownMarker(id=int(m["id"]), center=np.asarray(m["center"], dtype=float).reshape(2), side=float(m["side"]))
        for m in values["markers"]
    )
    return Photograph(
        path=path,
        width=int(values["width"]),
        height=int(values["height"]),
        K=np.asarray(values["K"], dtype=float).reshape(3, 3),
        D=np.asarray(values["D"], dtype=float).ravel(),
        markers=markers,
    )
