"""A piece on one sheet of paper, or on several that are glued together.

Several sheets overlap. The next sheet is cut along its left (upper) edge and laid on the one before it. A target is
printed on both sheets at the same place of the piece, just outside of it, and its middle lies on the cut: the half that
is left on the upper sheet completes the one below it when both are in place. Each row is joined first, then the rows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from seater_tools.sheets.layout.paper import FOOTER, HEADER, UNPRINTABLE, Paper
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.rect import Rect

OVERLAP = 10.0  # [mm] of two sheets, for the glue
MARKS = 9.0  # [mm] room beside a part of a piece for crop marks and targets
TARGET = 0.5 * MARKS  # [mm] from the part's edge to the middle of a target


@dataclass(frozen=True)
class Sheet:
    """One page: a part of a piece."""

    width: float  # of the page
    height: float
    shown: Rect  # the part, in the piece's frame
    origin: tuple[float, float]  # of the piece's frame on the page
    column: int = 0
    row: int = 0  # from the top
    lefts: tuple[float, ...] = (0.0,)  # left edges of the parts of all columns, in the piece's frame
    tops: tuple[float, ...] = (0.0,)  # upper edges of the parts of all rows

    @property
    def count(self) -> int:
        """Sheets of the piece."""
        return len(self.lefts) * len(self.tops)

    @property
    def on_page(self) -> Rect:
        """The part, on the page."""
        return self.shown.shifted(*self.origin)

    def targets(self) -> list[tuple[float, float]]:
        """Middles of the targets on this sheet, in the piece's frame."""
        shown = self.shown
        seams_x = self.lefts[max(self.column, 1) : self.column + 2]
        seams_y = self.tops[max(self.row, 1) : self.row + 2]
        outer = [shown.x0 - TARGET] if self.column == 0 else []
        outer += [shown.x1 + TARGET] if self.column == len(self.lefts) - 1 else []
        across = [(x, y) for x in seams_x for y in (shown.y1 + TARGET, shown.y0 - TARGET)]
        return across + [(x, y) for y in seams_y for x in outer]


def sheets_of(piece: Piece, paper: Paper) -> list[Sheet]:
    """The pages of a piece, row by row: one where it fits, else as few as possible, upright or lengthwise."""
    cut = piece.cut
    width, height = _room(paper.width, paper.height, 0.0)
    if cut.width <= width + 1e-6 and cut.height <= height + 1e-6:
        return [Sheet(paper.width, paper.height, cut, _origin(paper.width, paper.height, cut))]
    upright = _tiled(cut, paper.width, paper.height)
    lengthwise = _tiled(cut, paper.height, paper.width)
    return upright if len(upright) <= len(lengthwise) else lengthwise


def _room(width: float, height: float, marks: float) -> tuple[float, float]:
    """For a part on a page."""
    return width - 2 * UNPRINTABLE - 2 * marks, height - HEADER - FOOTER - 2 * marks


def _origin(width: float, height: float, shown: Rect) -> tuple[float, float]:
    """Of the piece's frame, when the part is in the middle between header and footer."""
    x, y = shown.middle
    return 0.5 * width - x, 0.5 * (FOOTER + height - HEADER) - y


def _tiled(cut: Rect, width: float, height: float) -> list[Sheet]:
    room = _room(width, height, MARKS)
    part_width, lefts = _parts(cut.x0, cut.width, room[0])
    part_height, bottoms = _parts(cut.y0, cut.height, room[1])
    tops = [bottom + part_height for bottom in reversed(bottoms)]
    sheets = []
    for row, top in enumerate(tops):
        for column, left in enumerate(lefts):
            shown = Rect(left, top - part_height, left + part_width, top)
            origin = _origin(width, height, shown)
            sheets.append(Sheet(width, height, shown, origin, column, row, tuple(lefts), tuple(tops)))
    return sheets


def _parts(start: float, length: float, room: float) -> tuple[float, list[float]]:
    """Length of each part, and where each begins: all equally long, overlapping by OVERLAP."""
    count = max(1, math.ceil((length - OVERLAP) / (room - OVERLAP) - 1e-9))
    part = (length + (count - 1) * OVERLAP) / count
    return part, [start + i * (part - OVERLAP) for i in range(count)]
