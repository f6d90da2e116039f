"""Rows of the results: one for each folder and detector."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from seater_eval.photographs.board import board_of
from seater_eval.photographs.branches import count_broken
from seater_eval.photographs.detectors import CORNERS, SEATER
from seater_eval.photographs.measures import MarkerErrors, Matched, errors_on_board
from seater_eval.photographs.truth import Photograph, PhotographFolder
from seater_eval.report.statistics import spread

Errors = dict[tuple[str, int], MarkerErrors]  # of (photograph, id)


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What a detector made of a photograph."""

    matched: Matched
    milliseconds: float


def folder_rows(
    folder: PhotographFolder, looks: Mapping[str, tuple[Sequence[Photograph], Sequence[Seen]]]
) -> list[dict[str, Any]]:
    """`looks`: detector -> photographs and what it has seen in them."""
    rows, errors = [], {}
    for name, (photographs, seen) in looks.items():
        row, errors[name] = row_of(folder, name, photographs, seen)
        rows.append(row)
    for row in rows:
        row["shared"] = shared_with(errors[row["detector"]], errors[SEATER])
        if row["detector"] == SEATER and CORNERS in errors:
            row["branches"] = broken_by(errors[SEATER], errors[CORNERS])
    return rows


def shared_with(theirs: Errors, ours: Errors) -> dict[str, Any]:
    """Corner errors [px] on the markers that both have a truth for, each by its own corners: the easy ones are found
    by all."""
    both = theirs.keys() & ours.keys()
    return {
        "markers": len(both),
        "theirs": spread(c for key in both for c in theirs[key].corners),
        "ours": spread(c for key in both for c in ours[key].corners),
    }


def broken_by(ours: Errors, by_corners: Errors) -> dict[str, int]:
    """Branches that the corners had decided, against those of `ours`; the board's homography is the truth of both."""
    return count_broken({key: e.branch for key, e in by_corners.items()}, {key: e.branch for key, e in ours.items()})


def row_of(
    folder: PhotographFolder, name: str, photographs: Sequence[Photograph], seen: Sequence[Seen]
) -> tuple[dict[str, Any], Errors]:
    """Recall, false finds, errors on the board and times of one detector in one folder."""
    finds = [{i: f.corners for i, f in s.matched.found.items()} for s in seen]
    board = board_of(folder.board, list(zip(photographs, finds, strict=True)), folder.board_marker_side)
    by_marker = {
        (p.path.name, e.id): e
        for p, s in zip(photographs, seen, strict=True)
        if board
        for e in errors_on_board(board, p, s.matched.found)
    }
    errors = list(by_marker.values())
    stages = [f.stage for s in seen for f in s.matched.found.values() if f.stage]
    row = {
        "folder": folder.name,
        "detector": name,
        "images": len(seen),
        "markers": sum(len(p.markers) for p in photographs),
        "found": sum(len(s.matched.found) for s in seen),
        "false": sum(len(s.matched.false) for s in seen),
        "unlisted": sum(len(s.matched.unlisted) for s in seen),
        "milliseconds": spread(s.milliseconds for s in seen),
        "stages": {stage: stages.count(stage) for stage in sorted(set(stages))},
        "on_board": len(errors),
        "board_marker_side": None if board is None else board_side(folder, board.corners),
        "corner_px": spread(c for e in errors for c in e.corners),
        "inwards_px": float(np.median([e.inwards for e in errors])) if errors else None,
        "certain": sum(e.certain for e in errors),
        "wrong_and_certain": sum(e.wrong_and_certain for e in errors),
        "nees": nees_of(e.nees for e in errors),
        "corner_nees": nees_of(e.corner_nees for e in errors),
    }
    return row, by_marker


def board_side(folder: PhotographFolder, corners: dict[int, Any]) -> float | None:
    """Of a marker, in the unit of `board_marker_centers`."""
    a, b = sorted(corners)[:2]
    return float(
        np.linalg.norm(folder.board[a] - folder.board[b])
        / np.linalg.norm(corners[a].mean(axis=0) - corners[b].mean(axis=0))
    )


def nees_of(values: Any) -> dict[str, float | None]:
    """Mean and spread."""
    numbers = [v for v in values if v is not None]
    return {"mean": float(np.mean(numbers)) if numbers else None, **spread(numbers)}
