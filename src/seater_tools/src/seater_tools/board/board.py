"""What is printed: a chessboard, or a ChArUco board, whose corners have numbers: it may reach over the image's edge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CHESSBOARD, CHARUCO = "chessboard", "charuco"
DICTIONARY = "DICT_5X5_100"  # not that of the docks
MARKER = 0.75  # side of a marker over that of its square
SQUARES = {"a4": 0.024, "a3": 0.035}  # [m] that fit on a sheet with a margin round the board


@dataclass(frozen=True)
class Board:
    """Squares across and down; `square`: side [m], or any unit: a lens does not depend on it.

    Frame: the upper left corner of the upper left square, which is black; x right, y down, z = 0.
    """

    kind: str = CHARUCO
    columns: int = 7
    rows: int = 10
    square: float = SQUARES["a4"]

    def points(self) -> Array:
        """(n, 3) of the inner corners, row by row from the upper left one."""
        x, y = np.meshgrid(np.arange(1, self.columns), np.arange(1, self.rows))
        return self.square * np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3).astype(float)

    def black(self) -> list[tuple[int, int]]:
        """Column and row of the black squares."""
        return [(i, j) for j in range(self.rows) for i in range(self.columns) if i % 2 == j % 2]

    def markers(self) -> list[tuple[int, int]]:
        """Column and row of the squares with the markers 0, 1, ... (none on a chessboard): the white ones, by rows."""
        if self.kind == CHESSBOARD:
            return []
        return [(i, j) for j in range(self.rows) for i in range(self.columns) if i % 2 != j % 2]
