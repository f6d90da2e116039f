"""Pages as the printer makes them: the detector reads every marker, at its true size, and the quiet zone is white."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from printed import DEFAULT_DOCK, DPI, PIXEL, ROOT, Image, dock_of, dock_with, document_of, marker_pages, pages_of, read

from seater_common.geometry import Marker
from seater_tools.sheets.document import MarkerSheets
from seater_tools.sheets.layout.paper import FOOTER, PAPERS, UNPRINTABLE

# [mm] of a side: 300 dpi have pixels of 0.085 mm; the worst side measured 0.014 mm too short.
SIDE = 0.05
DOCKS = sorted((ROOT / "config" / "docks").glob("*.yaml"))
NARROW_FAMILY = """
bits: 3
border: 2
correctable_bits: 0
codes:
  - "110 010 001"
  - "101 100 110"
"""


def pixel(entry: MarkerSheets, x: float, y: float) -> tuple[float, float]:
    """Column and row of a point of the piece [mm], on its only sheet; a pixel's centre has integer coordinates."""
    sheet = entry.sheets[0]
    column, row = sheet.origin[0] + x, sheet.height - sheet.origin[1] - y
    return column / PIXEL - 0.5, row / PIXEL - 0.5


def assert_read(image: Image, entry: MarkerSheets, dictionary: str) -> None:
    """One marker, the right one, upright where it has to be, of the right size."""
    seen = read(image, dock_with(entry.marker, dictionary=dictionary))
    assert [marker.id for marker in seen] == [entry.marker.id]
    assert seen[0].sides == pytest.approx([1000.0 * entry.marker.size] * 4, abs=SIDE)
    assert seen[0].corners[0] == pytest.approx(pixel(entry, *(500.0 * entry.marker.size * np.array([-1, 1]))), abs=1.0)
    assert seen[0].centre == pytest.approx(pixel(entry, 0.0, 0.0), abs=1.0)


def assert_clean(image: Image, entry: MarkerSheets) -> None:
    """Black is black and white is white out to the end of the quiet zone: no hairlines, no writing, no marks.

    Pixels beside a change of colour are left out, where the edge lies inside of a pixel.
    """
    piece = entry.piece
    cells = np.pad(piece.pattern, 1, constant_values=1)
    left, top = pixel(entry, piece.quiet.x0, piece.quiet.y1)
    rows, columns = (np.arange(np.ceil(start), start + piece.quiet.width / PIXEL) for start in (top, left))
    index = [((at - start) * PIXEL / piece.cell).astype(int) for at, start in ((rows, top), (columns, left))]
    ideal = 255 * cells[np.ix_(*index)]
    edges = cv2.morphologyEx(ideal, cv2.MORPH_GRADIENT, np.ones((5, 5), np.uint8))
    found = image[np.ix_(rows.astype(int), columns.astype(int))]
    wrong = (found != ideal) & (edges == 0)
    assert not wrong.any(), f"{wrong.sum()} pixels, the first at {np.argwhere(wrong)[0]}"


@pytest.mark.parametrize("paper", ["a4", pytest.param("a3", marks=pytest.mark.extensive)])
@pytest.mark.parametrize("path", DOCKS, ids=lambda path: path.stem)
def test_the_detector_reads_every_sheet_of_the_shipped_docks(path: Path, paper: str) -> None:
    dock = dock_of(path)
    document = document_of(dock, paper)
    assert [len(entry.sheets) for entry in document.markers] == [1] * len(dock.markers)
    for index, entry in enumerate(document.markers):
        image = marker_pages(document, index)[0]
        assert image.shape == pytest.approx([PAPERS[paper].height / PIXEL, PAPERS[paper].width / PIXEL], abs=1.0)
        assert_read(image, entry, dock.dictionary)
        assert_clean(image, entry)


@pytest.mark.parametrize(
    ("dictionary", "marker_id"),
    [("ARUCO_MIP_36h12", 249), ("DICT_APRILTAG_36h11", 586), ("DICT_7X7_1000", 999), ("DICT_ARUCO_ORIGINAL", 7)],
)
def test_other_dictionaries(dictionary: str, marker_id: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(ROOT / "config" / "marker_families"))
    document = document_of(dock_with(Marker(marker_id, 0.12), dictionary=dictionary))
    image = marker_pages(document, 0)[0]
    assert_read(image, document.markers[0], dictionary)
    assert_clean(image, document.markers[0])


def test_a_family_of_ones_own(tmp_path: Path) -> None:
    """By its path; with a border of two cells, beside which the quiet zone is one."""
    family = tmp_path / "narrow.yaml"
    family.write_text(NARROW_FAMILY)
    document = document_of(dock_with(Marker(1, 0.08), dictionary=str(family)))
    image = marker_pages(document, 0)[0]
    assert_read(image, document.markers[0], str(family))
    assert_clean(image, document.markers[0])


def ends(profile: Image) -> float:
    """From the first to the last dark pixel of a row or column [mm]."""
    dark = np.flatnonzero(profile < 128)
    return float(dark[-1] - dark[0] + 1) * PIXEL


@pytest.mark.parametrize("paper", PAPERS)
def test_the_bars_have_their_length(paper: str) -> None:
    document = document_of(dock_of(DEFAULT_DOCK), paper)
    bar = PAPERS[paper].bar
    for number, page in enumerate(pages_of(document, 1, document.plan_pages + 1)):
        rows = slice(*(len(page) - round((UNPRINTABLE + up) / PIXEL) for up in (5.3, 0.7)))  # all of its thickness
        assert ends(page[rows].min(axis=0)) == pytest.approx(bar, abs=PIXEL), f"page {number + 1}"
    first = pages_of(document, 1, 1)[0]
    column = first[: -round(FOOTER / PIXEL), first.shape[1] - round((UNPRINTABLE + 5.0) / PIXEL)]
    assert ends(column) == pytest.approx(bar, abs=PIXEL)


def test_nothing_is_drawn_where_printers_cannot_reach() -> None:
    dock = dock_with(Marker(0, 0.15), Marker(1, 0.3), Marker(2, 0.01))
    document = document_of(dock)
    edge = int(UNPRINTABLE / PIXEL) - 1
    for page in pages_of(document, 1, document.plan_pages + 8):
        inner = page[edge:-edge, edge:-edge]
        assert np.count_nonzero(page < 255) == np.count_nonzero(inner < 255) > 0.001 * DPI


def test_the_same_dock_gives_the_same_bytes() -> None:
    dock = dock_of(DEFAULT_DOCK)
    assert document_of(dock).pdf == document_of(dock).pdf
