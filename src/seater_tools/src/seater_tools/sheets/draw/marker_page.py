"""Pages with a marker, or a part of one, at its true size."""

from __future__ import annotations

from dataclasses import dataclass

from seater_tools.sheets.draw.dimensions import number
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.draw.ruler import draw_footer
from seater_tools.sheets.layout.paper import FOOTER, HEADER, UNPRINTABLE, Paper
from seater_tools.sheets.layout.piece import STRIP, Piece
from seater_tools.sheets.layout.rect import Rect
from seater_tools.sheets.layout.tiles import MARKS, OVERLAP, TARGET, Sheet

GAP = 1.5  # [mm] between what is cut off and a mark beside it
RADIUS = 2.0  # [mm] of a target


@dataclass(frozen=True)
class Words:
    """What stands on the pages of a marker."""

    title: str  # which marker of which dock
    place: str  # where it hangs
    name: str  # the marker, in its upper strip
    note: str  # in its lower strip, left
    source: str  # option that names the dock file


def draw_sheet(pen: Pen, piece: Piece, sheet: Sheet, paper: Paper, words: Words) -> None:
    """A page of its own."""
    with pen.page(sheet.width, sheet.height):
        with pen.shifted(*sheet.origin, clip=sheet.shown):
            pen.fill(piece.black())
            _draw_strips(pen, piece, words)
        inside = Rect(UNPRINTABLE, FOOTER, sheet.width - UNPRINTABLE, sheet.height - HEADER)
        reach = inside.shifted(-sheet.origin[0], -sheet.origin[1])
        with pen.shifted(*sheet.origin):
            _draw_crop_marks(pen, piece.cut, sheet.shown, reach, len(sheet.tops) > 1)
            for x, y in sheet.targets():
                _draw_target(pen, x, y)
        _draw_header(pen, sheet, words)
        draw_footer(pen, sheet.width, paper, words.source)


def _draw_strips(pen: Pen, piece: Piece, words: Words) -> None:
    """Text and middle marks above and below the quiet zone, which is left alone; the lines to cut along."""
    cut, quiet = piece.cut, piece.quiet
    room = 0.5 * cut.width - 4.0
    for y, inward in ((cut.y1, -1.0), (cut.y0, 1.0)):
        _cut_line(pen, (cut.x0, y), (cut.x1, y))
        pen.line((0.0, y), (0.0, y + 5.0 * inward), width=0.2)
        for x in (cut.x0, cut.x1):
            _cut_line(pen, (x, y), (x, y + (STRIP - 1.0) * inward))
    middle = quiet.y1 + 0.5 * STRIP - 1.2
    pen.polygon([(cut.x0 + 3.0, middle), (cut.x0 + 8.0, middle), (cut.x0 + 5.5, middle + 5.0)])
    pen.text(cut.x0 + 9.5, middle, "UP", 10.0, bold=True)
    pen.text(cut.x1 - 2.0, middle, words.name, 10.0, "right", bold=True, fit=room)
    half = f"centre {number(0.5 * cut.height)} mm below upper edge"
    pen.text(cut.x0 + 2.0, cut.y0 + 7.0, words.note, 8.0, fit=cut.width - 4.0)
    pen.text(cut.x0 + 2.0, cut.y0 + 2.5, half, 8.0, fit=room)


def _cut_line(pen: Pen, start: tuple[float, float], end: tuple[float, float]) -> None:
    pen.line(start, end, width=0.15, grey=0.45, dash=(2.0, 1.5))


def _draw_crop_marks(pen: Pen, cut: Rect, shown: Rect, inside: Rect, seams: bool) -> None:
    """Outside of the part: at the corners of the cut, and where its edges have their middle (not beside `seams`, the
    targets of which lie there).

    `inside`: what the printer reaches, less header and footer; a mark that would be shorter than half is left out.
    """
    for x in (cut.x0, 0.0, cut.x1):
        for y, out in ((cut.y0, -1.0), (cut.y1, 1.0)):
            if shown.contains(x, y):
                _mark(pen, (x, y + GAP * out), (x, y + (MARKS - GAP) * out), inside)
    for y in (cut.y0, cut.y1) if seams else (cut.y0, 0.0, cut.y1):
        for x, out in ((cut.x0, -1.0), (cut.x1, 1.0)):
            if shown.contains(x, y):
                _mark(pen, (x + GAP * out, y), (x + (MARKS - GAP) * out, y), inside)


def _mark(pen: Pen, start: tuple[float, float], end: tuple[float, float], inside: Rect) -> None:
    stop = (min(max(end[0], inside.x0), inside.x1), min(max(end[1], inside.y0), inside.y1))
    if inside.contains(*start) and abs(stop[0] - start[0]) + abs(stop[1] - start[1]) > 0.5 * (MARKS - 2 * GAP):
        pen.line(start, stop)


def _draw_target(pen: Pen, x: float, y: float) -> None:
    reach = TARGET - 0.5
    pen.circle(x, y, RADIUS)
    pen.line((x - reach, y), (x + reach, y))
    pen.line((x, y - reach), (x, y + reach))


def _draw_header(pen: Pen, sheet: Sheet, words: Words) -> None:
    top, left = sheet.height - UNPRINTABLE, UNPRINTABLE + 5.0
    second = f"Print at 100 % (actual size). {words.place}"
    room = sheet.width - 2 * left
    if sheet.count > 1:
        room -= 22.0
        order = sheet.row * len(sheet.lefts) + sheet.column + 1
        second = f"Sheet {order} of {sheet.count} (row {sheet.row + 1}, column {sheet.column + 1}). {joining(sheet)}"
        _draw_grid(pen, sheet, sheet.width - left, top)
    pen.text(left, top - 5.0, words.title, 10.0, bold=True, fit=room)
    pen.text(left, top - 10.0, second, 8.0, fit=room)


def joining(sheet: Sheet) -> str:
    """How this sheet meets its neighbours."""
    edges = [name for name, later in (("left", sheet.column > 0), ("upper", sheet.row > 0)) if later]
    if not edges:
        return f"The next sheets overlap it by {OVERLAP:.0f} mm and more."
    return f"Cut its {' and '.join(edges)} edge through the targets, glue it over the sheet there."


def _draw_grid(pen: Pen, sheet: Sheet, right: float, top: float) -> None:
    """Which of the sheets this is."""
    columns, rows = len(sheet.lefts), len(sheet.tops)
    side = min(20.0 / columns, 11.0 / rows, 5.0)
    left = right - side * columns
    x, y = left + side * sheet.column, top - side * (sheet.row + 1)
    pen.fill([Rect(x, y, x + side, y + side)], grey=0.4)
    for column in range(columns):
        for row in range(rows):
            x, y = left + side * column, top - side * (row + 1)
            pen.frame(Rect(x, y, x + side, y + side))
