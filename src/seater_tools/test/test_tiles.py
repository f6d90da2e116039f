"""A marker that is bigger than the paper: joined by its targets, as a person does it, its sheets are one marker."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from printed import PIXEL, Image, dock_with, document_of, marker_pages, read

from seater_common.geometry import Marker
from seater_common.marker_family import marker_family
from seater_tools.sheets.layout.paper import FOOTER, HEADER, PAPERS, UNPRINTABLE
from seater_tools.sheets.layout.piece import Piece
from seater_tools.sheets.layout.tiles import MARKS, OVERLAP, Sheet, sheets_of

BIG = 0.3  # [m]
Point = NDArray[np.float64]


def piece_of(size: float, dictionary: str = "DICT_4X4_50") -> Piece:
    return Piece(marker_family(dictionary).print_of(1), size)


def target_pixel(image: Image, sheet: Sheet, target: tuple[float, float]) -> Point:
    """Where a target was printed (column, row): the middle of its ink within 2.3 mm, its circle."""
    x, y = sheet.origin[0] + target[0], sheet.height - sheet.origin[1] - target[1]
    radius, corner = 2.3 / PIXEL, np.round((np.array([x, y]) - 2.5) / PIXEL).astype(int)
    window = image[corner[1] :, corner[0] :][: round(5.0 / PIXEL), : round(5.0 / PIXEL)]
    rows, columns = np.mgrid[: window.shape[0], : window.shape[1]]
    middle = np.array([x, y]) / PIXEL - 0.5 - corner
    ink = (255.0 - window) * ((columns - middle[0]) ** 2 + (rows - middle[1]) ** 2 < radius**2)
    assert ink.sum() > 0.0, f"no target at {target}"
    return np.array([(columns * ink).sum(), (rows * ink).sum()]) / ink.sum() + corner


def step(images: list[Image], sheets: list[Sheet], a: int, b: int) -> Point:
    """How far sheet b lies from sheet a [px] when the targets that both have are on top of each other."""
    shared = sorted(set(sheets[a].targets()) & set(sheets[b].targets()))
    assert len(shared) == 2 or sheets[a].column == sheets[b].column
    found = [target_pixel(images[a], sheets[a], t) - target_pixel(images[b], sheets[b], t) for t in shared]
    assert np.ptp(found, axis=0) == pytest.approx([0.0, 0.0], abs=1.0)
    return np.mean(found, axis=0)


def joined(images: list[Image], sheets: list[Sheet]) -> Image:
    """Each row from left to right, then the rows from above; a later sheet covers the one before it."""
    columns = len(sheets[0].lefts)
    places = [np.zeros(2)]
    for i in range(1, len(sheets)):
        before = i - 1 if i % columns else i - columns
        places.append(places[before] + step(images, sheets, before, i))
    big = np.full((int(480.0 / PIXEL), int(480.0 / PIXEL)), 255, np.uint8)
    corner = np.array([sheets[0].on_page.x0, sheets[0].height - sheets[0].on_page.y1]) / PIXEL
    for image, sheet, place in zip(images, sheets, places, strict=True):
        part = sheet.on_page
        source = np.array([part.x0, sheet.height - part.y1]) / PIXEL
        target = source - corner + place + 20.0 / PIXEL
        x, y = np.floor(target).astype(int)
        shift = np.column_stack([np.eye(2), source + np.floor(target) - target])  # to a fraction of a pixel
        size = round(part.width / PIXEL), round(part.height / PIXEL)
        moved = cv2.warpAffine(image, shift, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
        big[y : y + size[1], x : x + size[0]] = moved
    return big


@pytest.mark.parametrize("paper", PAPERS)
def test_the_joined_sheets_are_one_marker(paper: str) -> None:
    dock = dock_with(Marker(1, BIG))
    document = document_of(dock, paper)
    sheets = document.markers[0].sheets
    assert len(sheets) == {"a4": 6, "a3": 4}[paper]
    big = joined(marker_pages(document, 0), sheets)
    seen = read(big, dock, shrink=2)  # no camera's image has 3500 pixels along a marker
    assert [marker.id for marker in seen] == [1]
    # Each target's place is known to a fraction of its pixels of 0.085 mm; the worst side measured 0.05 mm.
    assert seen[0].sides == pytest.approx([1000.0 * BIG] * 4, abs=0.1)
    assert_white_around(big, seen[0].corners, round((document.markers[0].piece.cell - 1.0) / PIXEL))


def assert_white_around(image: Image, corners: NDArray[np.float64], width: int) -> None:
    """From 3 pixels beside the marker to `width` [px], on all sides."""
    (left, top), (right, bottom) = (np.round(corners[i]).astype(int) for i in (0, 2))
    around = image[top - width : bottom + width, left - width : right + width].copy()
    around[width - 3 : -(width - 3), width - 3 : -(width - 3)] = 255
    assert (around == 255).all()


@pytest.mark.parametrize("size", [151.0, 220.0, 300.0, 480.0, 1000.0])
@pytest.mark.parametrize("paper", PAPERS)
def test_sheets_cover_a_piece_and_overlap(paper: str, size: float) -> None:
    piece = piece_of(size)
    sheets = sheets_of(piece, PAPERS[paper])
    assert min(s.shown.x0 for s in sheets) == pytest.approx(piece.cut.x0)
    assert min(s.shown.y0 for s in sheets) == pytest.approx(piece.cut.y0)
    assert max(s.shown.x1 for s in sheets) == pytest.approx(piece.cut.x1)
    assert max(s.shown.y1 for s in sheets) == pytest.approx(piece.cut.y1)
    for a, b in pairwise(sheets):
        if a.row == b.row:
            assert a.shown.x1 - b.shown.x0 == pytest.approx(OVERLAP)
    for a, b in zip(sheets, sheets[len(sheets[0].lefts) :], strict=False):
        assert b.shown.y1 - a.shown.y0 == pytest.approx(OVERLAP)
    marks = MARKS if len(sheets) > 1 else 0.0
    for sheet in sheets:
        part = sheet.on_page
        assert part.x0 >= UNPRINTABLE + marks - 1e-6 and part.x1 <= sheet.width - UNPRINTABLE - marks + 1e-6
        assert part.y0 >= FOOTER + marks - 1e-6 and part.y1 <= sheet.height - HEADER - marks + 1e-6


def test_one_sheet_where_it_fits() -> None:
    """A4 takes 150 mm of a family with 6 cells: 200 mm with the quiet zone, all that a printer reaches."""
    assert len(sheets_of(piece_of(150.0), PAPERS["a4"])) == 1
    assert len(sheets_of(piece_of(150.5), PAPERS["a4"])) > 1
    assert len(sheets_of(piece_of(215.0), PAPERS["a3"])) == 1


@pytest.mark.parametrize("dictionary", ["DICT_4X4_50", "DICT_7X7_50"])
@pytest.mark.parametrize("size", [5.0, 60.0, 400.0])
def test_a_piece_is_its_pattern(size: float, dictionary: str) -> None:
    """Every cell's middle lies in one black rectangle if it is black, else in none; the quiet zone is a cell wide."""
    piece = piece_of(size, dictionary)
    cells = len(piece.pattern)
    for row in range(-1, cells + 1):
        for column in range(-1, cells + 1):
            x, y = (column + 0.5) * piece.cell - 0.5 * size, 0.5 * size - (row + 0.5) * piece.cell
            black = 0 <= row < cells and 0 <= column < cells and piece.pattern[row, column] == 0
            assert sum(rect.contains(x, y) for rect in piece.black()) == black
            assert piece.quiet.contains(x, y)
    assert not piece.quiet.contains(0.0, 0.5 * size + 1.01 * piece.cell)
    assert piece.cut.width >= max(piece.quiet.width, 60.0)
