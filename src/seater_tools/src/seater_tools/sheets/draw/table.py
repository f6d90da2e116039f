"""The markers of a dock as a table."""

from __future__ import annotations

from collections.abc import Sequence

from seater_common.geometry import Dock, Marker
from seater_tools.sheets.draw.dimensions import number
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.views import facing, turn_of

ROW = 5.0  # [mm]
HEAD = 9.0  # [mm] of the table: two lines
# Share of the width, and the two lines of the head.
COLUMNS = (
    (0.07, "id", ""),
    (0.08, "side", "mm"),
    (0.17, "centre beside the", "bay's middle, mm"),
    (0.14, "centre above", "the floor, mm"),
    (0.20, "upper edge of the cut", "sheet above floor, mm"),
    (0.17, "print in front of", "the back wall, mm"),
    (0.17, "faces", ""),
)


def beside(marker: Marker) -> tuple[str, str]:
    """How far it hangs beside the middle of the bay [mm], and on which side for somebody who looks into it."""
    y = 1000.0 * marker.position[1]
    return ("0", "") if abs(y) < 0.05 else (number(abs(y)), "left" if y > 0 else "right")


def draw_table(
    pen: Pen, dock: Dock, markers: Sequence[Marker], pieces: dict[int, Piece], x: float, y: float, width: float
) -> float:
    """From its upper left corner downwards. Returns its height [mm]."""
    edges = [x + width * sum(share for share, _, _ in COLUMNS[:i]) for i in range(len(COLUMNS))]
    for edge, (share, first, second) in zip(edges, COLUMNS, strict=True):
        room = share * width - 2.0
        pen.text(edge, y - 3.5, first, 7.0, bold=True, fit=room)
        pen.text(edge, y - 7.0, second, 7.0, bold=True, fit=room)
    pen.line((x, y - HEAD), (x + width, y - HEAD), width=0.3)
    for i, marker in enumerate(markers):
        low = y - HEAD - ROW * (i + 1)
        for edge, words, (share, _, _) in zip(edges, _cells(dock, marker, pieces), COLUMNS, strict=True):
            pen.text(edge, low + 1.5, words, 8.0, fit=share * width - 2.0)
        pen.line((x, low), (x + width, low), width=0.1, grey=0.6)
    return HEAD + ROW * len(markers)


def _cells(dock: Dock, marker: Marker, pieces: dict[int, Piece]) -> list[str]:
    height = 1000.0 * marker.position[2]
    return [
        str(marker.id),
        number(1000.0 * marker.size),
        " ".join(beside(marker)),
        number(height),
        number(height + 0.5 * pieces[marker.id].cut.height),
        number(1000.0 * (dock.bay.back_wall_x - marker.position[0])),
        facing(turn_of(marker)),
    ]
