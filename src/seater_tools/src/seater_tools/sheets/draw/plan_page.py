"""Pages that say where the markers hang, and how."""

from __future__ import annotations

from collections.abc import Sequence

from seater_common.geometry import Dock, Marker
from seater_tools.sheets.draw.elevation import draw_elevation
from seater_tools.sheets.draw.from_above import draw_from_above
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.draw.ruler import THICK, draw_bar, draw_footer
from seater_tools.sheets.draw.table import HEAD, ROW, draw_table
from seater_tools.sheets.layout.paper import FOOTER, HEADER, UNPRINTABLE, Paper
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.rect import Rect
from seater_tools.sheets.layout.views import View

Pieces = dict[int, Piece]
STEPS = (
    "1. Print every page at 100 % (actual size, no fitting to the page) on matt paper.",
    "2. Measure both bars of page 1 with a steel ruler. If they are not {bar:.0f} mm long:",
    "    ./seater sheets {source} --paper {paper} --measured-bar ACROSS UPWARDS",
    "    and use the copy of the dock file that it writes.",
    "3. A marker of several sheets: join each row from left to right, then the rows from above, as each head says.",
    "4. Glue each print on something flat and stiff, without bubbles and without a glossy film over it. Cut along the",
    "    dashed lines and the marks. The white round the black square has to stay white: nothing on it.",
    "5. Draw a plumb line in the middle of the bay, and a level line at the height of the centres. Half of a cut sheet",
    "    is above its marker's centre, half below; middle marks are on its edges.",
    "6. Hang the prints upright, the arrow UP. Measure from centre to centre and from the floor, to a millimetre.",
    "7. Where a print hangs elsewhere than planned, write what you measured into the dock file (position, normal_yaw).",
)


def draw_plan(pen: Pen, dock: Dock, views: Sequence[View], pieces: Pieces, paper: Paper, source: str) -> None:
    """Page 1: the front view with the table and both bars; then one page for each other view; then the bay from above
    and what to do."""
    room = Rect(12.0, FOOTER + 2.0, paper.width - 22.0, paper.height - HEADER - 2.0)
    title = f"Dock '{dock.name}': where its {len(dock.markers)} markers ({dock.dictionary}) hang"
    rest = list(dock.markers)
    for number, view in enumerate(views):
        with pen.page(paper.width, paper.height):
            _head(pen, paper, title, view.title)
            rows = _rows(0.5 * room.height, len(rest)) if number == 0 else 0
            space = HEAD + ROW * rows + 8.0 if rows else 0.0
            frame = draw_elevation(pen, view, pieces, dock.bay, Rect(room.x0, room.y0 + space, room.x1, room.y1))
            pen.text(room.x1, paper.height - UNPRINTABLE - 10.0, f"1 : {frame.scale:g}, lengths in mm", 8.0, "right")
            if rows:
                draw_table(pen, dock, rest[:rows], pieces, room.x0, frame.lowest - 8.0, room.width)
                _draw_upright_bar(pen, paper)
                rest = rest[rows:]
            draw_footer(pen, paper.width, paper, source)
    _draw_rest(pen, dock, rest, pieces, paper, title, source, room)
    with pen.page(paper.width, paper.height):
        _head(pen, paper, title, "The bay from above, and what to do")
        low = _draw_steps(pen, room, paper, source)
        draw_from_above(pen, dock, Rect(room.x0, low, room.x1, room.y1))
        draw_footer(pen, paper.width, paper, source)


def _rows(room: float, wanted: int) -> int:
    """Of a table in this height."""
    return min(wanted, int((room - HEAD) // ROW))


def _draw_rest(
    pen: Pen, dock: Dock, rest: list[Marker], pieces: Pieces, paper: Paper, title: str, source: str, room: Rect
) -> None:
    """The rows of the table that page 1 had no room for."""
    while rest:
        rows = _rows(room.height, len(rest))
        with pen.page(paper.width, paper.height):
            _head(pen, paper, title, "Further markers")
            draw_table(pen, dock, rest[:rows], pieces, room.x0, room.y1, room.width)
            draw_footer(pen, paper.width, paper, source)
        rest = rest[rows:]


def _head(pen: Pen, paper: Paper, title: str, second: str) -> None:
    top = paper.height - UNPRINTABLE
    pen.text(12.0, top - 5.0, title, 12.0, bold=True, fit=paper.width - 24.0)
    pen.text(12.0, top - 10.0, second, 9.0)


def _draw_upright_bar(pen: Pen, paper: Paper) -> None:
    draw_bar(pen, paper.width - UNPRINTABLE - 3.0 - THICK, FOOTER + 6.0, paper.bar, upright=True)


def _draw_steps(pen: Pen, room: Rect, paper: Paper, source: str) -> float:
    """At the lower end of the page. Returns how far up they reach."""
    line = 4.6
    for i, step in enumerate(STEPS):
        words = step.format(bar=paper.bar, paper=paper.name, source=source)
        pen.text(room.x0, room.y0 + line * (len(STEPS) - 1 - i), words, 8.5, fit=paper.width - 2 * room.x0)
    return room.y0 + line * len(STEPS) + 4.0
