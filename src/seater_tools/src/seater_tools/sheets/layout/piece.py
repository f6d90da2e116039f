"""The piece of paper that is hung up: a marker, its quiet zone, and a strip for writing above and below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seater_tools.sheets.layout.rect import Rect

STRIP = 12.0  # [mm] height of a strip
NARROWEST = 60.0  # [mm] of a piece: the strips' text stays readable


@dataclass(frozen=True, eq=False)
class Piece:
    """In its own frame: origin at the marker's centre, x right and y up as the print is read [mm].

    `pattern`: (cells, cells), row 0 on top, 1 white, 0 black, the black border included (MarkerFamily.print_of).
    """

    pattern: NDArray[np.uint8]
    size: float  # side of the black square

    @property
    def cell(self) -> float:
        return self.size / len(self.pattern)

    @property
    def quiet(self) -> Rect:
        """The square that stays white round the black one: a cell wider on every side, as detectors ask for."""
        side = self.size + 2 * self.cell
        return Rect.centred(side, side)

    @property
    def cut(self) -> Rect:
        """Where the paper is cut. The marker's centre is its middle, so that its edges can be halved on the wall."""
        return Rect.centred(max(self.quiet.width, NARROWEST), self.quiet.height + 2 * STRIP)

    def black(self) -> list[Rect]:
        """The black cells: neighbours in a row, and equal rows below each other, are one rectangle."""
        half, cell, found = 0.5 * self.size, self.cell, list[Rect]()
        for first, last in _equal_rows(self.pattern):
            for left, right in _black_runs(self.pattern[first]):
                found.append(
                    Rect(left * cell - half, half - (last + 1) * cell, right * cell - half, half - first * cell)
                )
        return found


def _equal_rows(pattern: NDArray[np.uint8]) -> list[tuple[int, int]]:
    """First and last index of each group of equal rows that follow each other."""
    starts = [0, *(i for i in range(1, len(pattern)) if not np.array_equal(pattern[i], pattern[i - 1]))]
    return list(zip(starts, [*(start - 1 for start in starts[1:]), len(pattern) - 1], strict=True))


def _black_runs(row: NDArray[np.uint8]) -> list[tuple[int, int]]:
    """First column and the one behind the last, of each run of zeros."""
    change = np.flatnonzero(np.diff(np.concatenate([[1], row, [1]]).astype(int)))
    return [(int(a), int(b)) for a, b in change.reshape(-1, 2)]
