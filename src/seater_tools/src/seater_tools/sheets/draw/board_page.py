"""A page with a board for the calibration of a lens."""

from __future__ import annotations

from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_tools.board.board import CHARUCO, DICTIONARY, MARKER, Board
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.draw.ruler import draw_bar
from seater_tools.sheets.layout.paper import FOOTER, HEADER, UNPRINTABLE, Paper
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.rect import Rect


def board_pdf(board: Board, paper: Paper) -> bytes:
    """One page. Raises ParameterError: the board does not fit, or has more markers than there are."""
    side = 1000.0 * board.square
    width, height = board.columns * side, board.rows * side
    room = paper.width - 2 * UNPRINTABLE, paper.height - HEADER - FOOTER
    if width > room[0] or height > room[1]:
        raise ParameterError(
            f"a board of {width:.0f} x {height:.0f} mm does not fit on {paper.name} ({room[0]:.0f} x {room[1]:.0f} mm)"
        )
    pen = Pen(f"{board.kind} of {board.columns} x {board.rows} squares")
    left, top = 0.5 * (paper.width - width), 0.5 * (FOOTER + paper.height - HEADER + height)
    with pen.page(paper.width, paper.height):
        squares = [Rect(i * side, -(j + 1) * side, (i + 1) * side, -j * side) for i, j in board.black()]
        with pen.shifted(left, top):
            pen.fill(squares)
        for id, (i, j) in enumerate(board.markers()):
            with pen.shifted(left + (i + 0.5) * side, top - (j + 0.5) * side):
                pen.fill(_black(id, MARKER * side))
        _words(pen, board, paper, side)
    return pen.finish()


def _black(id: int, side: float) -> list[Rect]:
    """Of a marker, in its own frame."""
    family = marker_family(DICTIONARY)
    if id >= len(family):
        raise ParameterError(f"the board has more white squares than the {len(family)} markers of {DICTIONARY}")
    return Piece(family.print_of(id), side).black()


def _words(pen: Pen, board: Board, paper: Paper, side: float) -> None:
    width = paper.width - 4 * UNPRINTABLE
    kind = "ChArUco board" if board.kind == CHARUCO else "Chessboard"
    title = f"{kind} of {board.columns} x {board.rows} squares of {side:g} mm, for the calibration of a lens"
    pen.text(2 * UNPRINTABLE, paper.height - 11.0, title, 11.0, bold=True, fit=width)
    bar = 0.5 * (paper.width - paper.bar)
    draw_bar(pen, bar, UNPRINTABLE + 1.0, paper.bar)
    first = "Glue it on something flat and stiff. Its size does not matter for a lens, its flatness does."
    squares = "" if (board.columns, board.rows) == (7, 10) else f" --squares {board.columns} {board.rows}"
    second = f"./seater calibrate camera --board {board.kind}{squares} --images FOLDER"
    pen.text(bar, UNPRINTABLE + 15.5, first, 7.5, fit=paper.bar)
    pen.text(bar, UNPRINTABLE + 11.5, second, 7.5, fit=paper.bar)
