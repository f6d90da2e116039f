"""The PDF of a dock: where its markers hang, then every marker at its true size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from seater_common.geometry import Dock, Marker
from seater_common.marker_family import MarkerFamily
from seater_common.params import ParameterError
from seater_tools.sheets.draw.dimensions import number
from seater_tools.sheets.draw.marker_page import Words, draw_sheet
from seater_tools.sheets.draw.pen import Pen
from seater_tools.sheets.draw.plan_page import draw_plan
from seater_tools.sheets.draw.table import beside
from seater_tools.sheets.layout.paper import Paper
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.tiles import Sheet, sheets_of
from seater_tools.sheets.layout.views import views_of


@dataclass(frozen=True)
class MarkerSheets:
    """The pages of a marker."""

    marker: Marker
    piece: Piece
    sheets: list[Sheet]


@dataclass(frozen=True)
class Document:
    """`pdf`: the file; its last pages are the sheets of `markers`, in this order."""

    pdf: bytes
    markers: list[MarkerSheets]
    plan_pages: int


def make_document(dock: Dock, family: MarkerFamily, paper: Paper, source: str, option: str = "") -> Document:
    """`source`: the dock file, as a person would type it; `option`: that names it to the command (--dock `source`).

    Raises:
        ParameterError: naming every marker whose id the family does not have, or whose print cannot tell what is up.
    """
    markers = [MarkerSheets(marker, piece, sheets_of(piece, paper)) for marker, piece in _pieces(dock, family, source)]
    pieces = {entry.marker.id: entry.piece for entry in markers}
    pen = Pen(f"Markers of the dock {dock.name}")
    option = option or f"--dock {source}"
    draw_plan(pen, dock, views_of(dock), pieces, paper, option)
    plan_pages = pen.pages
    for entry in markers:
        words = _words(dock, family, entry.marker, option)
        for sheet in entry.sheets:
            draw_sheet(pen, entry.piece, sheet, paper, words)
    return Document(pen.finish(), markers, plan_pages)


def _pieces(dock: Dock, family: MarkerFamily, source: str) -> list[tuple[Marker, Piece]]:
    found, problems = [], []
    for i, marker in enumerate(dock.markers):
        key = f"{source}/markers[{i}]/id: is {marker.id}"
        if marker.id >= len(family):
            problems.append(f"{key}, must be 0 to {len(family) - 1} ({family.name})")
            continue
        pattern = family.print_of(marker.id)
        if any(np.array_equal(pattern, np.rot90(pattern, turns)) for turns in (1, 2)):
            problems.append(f"{key}, which looks the same when turned: no detector can tell its pose; take another")
        found.append((marker, Piece(pattern, 1000.0 * marker.size)))
    if problems:
        raise ParameterError("wrong parameters:\n  " + "\n  ".join(problems))
    return found


def _words(dock: Dock, family: MarkerFamily, marker: Marker, source: str) -> Words:
    side = f"{number(1000.0 * marker.size)} mm"
    offset, way = beside(marker)
    where = f"{offset} mm {way} of the bay's middle" if way else "in the middle of the bay"
    return Words(
        title=f"Dock '{dock.name}': marker {marker.id} of {family.name}, side {side}",
        place=f"Hang it upright, its centre {number(1000.0 * marker.position[2])} mm above the floor, {where}.",
        name=f"id {marker.id}  {family.name}",
        note=f"dock {dock.name}, side {side}",
        source=source,
    )
