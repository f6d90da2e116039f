"""A picture of what was missed, and of what was found and is not there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from seater_eval.photographs.detectors import SEATER, Found, Image
from seater_eval.photographs.evaluate import read_image
from seater_eval.photographs.rows import Seen
from seater_eval.photographs.truth import KnownMarker, PhotographFolder

TILE, COLUMNS, MOST = 120, 12, 240  # [px], tiles
MISSED, FALSE = (0, 140, 255), (0, 0, 255)  # BGR


def draw_contact_sheet(
    folders: Sequence[PhotographFolder], seen: dict[tuple[str, str], list[Seen]], step: int, path: Path
) -> Path:
    """One tile for each missed (orange) or false (red) marker of ours, folder by folder, `MOST` at most. `step`: every
    how manieth photograph was looked at."""
    tiles = []
    for folder in folders:
        for photograph, s in zip(folder.photographs[::step], seen[folder.name, SEATER], strict=True):
            if not (s.matched.missed or s.matched.false):
                continue
            image = read_image(photograph)
            name = f"{folder.name[:8]}/{photograph.path.stem}"
            tiles += [tile(image, marker, f"{name} {marker.id}", MISSED) for marker in s.matched.missed]
            tiles += [tile(image, place_of_find(found), f"{name} {found.id}", FALSE) for found in s.matched.false]
    return write_sheet(tiles, path)


def write_sheet(tiles: Sequence[Image], path: Path) -> Path:
    """`MOST` tiles at most, a white one when there are none."""
    tiles = list(tiles[:MOST]) or [np.full((TILE, TILE, 3), 255, np.uint8)]
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % COLUMNS)
    rows = [np.hstack(tiles[k : k + COLUMNS]) for k in range(0, len(tiles), COLUMNS)]
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.vstack(rows))
    return path


def place_of_find(found: Found) -> KnownMarker:
    """As if the find were there."""
    side = float(np.linalg.norm(found.corners - np.roll(found.corners, 1, axis=0), axis=1).mean())
    return KnownMarker(id=found.id, center=found.corners.mean(axis=0), side=side)


def tile(image: Image, marker: KnownMarker, text: str, colour: tuple[int, int, int]) -> Image:
    """The marker with half its side round it, enlarged to TILE."""
    half = max(8.0, marker.side)
    scale = (TILE - 14) / (2.0 * half)
    move = np.array([[scale, 0.0, scale * (half - marker.center[0])], [0.0, scale, scale * (half - marker.center[1])]])
    part = cv2.warpAffine(image, move, (TILE, TILE - 14), flags=cv2.INTER_NEAREST, borderValue=128)
    tile = cv2.copyMakeBorder(cv2.cvtColor(part, cv2.COLOR_GRAY2BGR), 0, 14, 0, 0, 0, value=(255, 255, 255))
    cv2.putText(tile, text, (2, TILE - 4), cv2.FONT_HERSHEY_SIMPLEX, 0.32, (0, 0, 0), 1, cv2.LINE_AA)
    cv2.rectangle(tile, (0, 0), (TILE - 1, TILE - 1), colour, 2)
    return np.asarray(tile, dtype=np.uint8)
