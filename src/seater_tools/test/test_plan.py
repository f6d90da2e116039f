"""Where the markers hang: views of the dock, and the numbers on the pages."""

from __future__ import annotations

import math
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from printed import DEFAULT_DOCK, dock_of, dock_with, document_of

from seater_common.geometry import Bay, Dock, Marker
from seater_tools.sheets.layout.views import views_of


def text_of(dock: Dock, page: int, folder: Path) -> str:
    """What stands on a page of the PDF, runs of blanks as one."""
    pdf = folder / "sheets.pdf"
    pdf.write_bytes(document_of(dock).pdf)
    words = ["pdftotext", "-layout", "-f", str(page), "-l", str(page), str(pdf), "-"]
    return re.sub(r" +", " ", subprocess.run(words, check=True, capture_output=True, text=True).stdout)


def test_the_front_view_is_seen_by_who_looks_into_the_bay() -> None:
    """y of the dock frame points to the left."""
    view = views_of(dock_with(Marker(0, 0.1, [0.9, 0.2, 0.7]), Marker(1, 0.1, [0.85, -0.3, 0.5], -math.pi)))[0]
    assert [(place.marker.id, place.x, place.height) for place in view.places] == [
        (0, pytest.approx(-200.0), 700.0),
        (1, pytest.approx(300.0), 500.0),
    ]
    assert view.title == "Front view, looking into the bay" and view.reference == "middle of the bay"


def test_a_marker_on_a_side_wall_has_a_view_of_its_own() -> None:
    """Who looks at the left wall (y = 0.5 m) has the back wall on the right: x = 0 there, the marker left of it."""
    left, right = Marker(1, 0.1, [0.6, 0.5, 0.7], -0.5 * math.pi), Marker(2, 0.1, [0.6, -0.5, 0.7], 0.5 * math.pi)
    front, *sides = views_of(dock_with(right, left, Marker(0)))
    assert [place.marker.id for place in front.places] == [0]
    found = {view.places[0].marker.id: view for view in sides}
    assert found[1].places[0].x == pytest.approx(-300.0) and found[2].places[0].x == pytest.approx(300.0)
    assert found[1].title == "View of the markers that face 90.0 deg to the right"
    assert found[2].title == "View of the markers that face 90.0 deg to the left"
    assert found[1].reference == found[2].reference == "back wall"


def test_slanted_markers_are_measured_from_each_other_only() -> None:
    view = views_of(dock_with(Marker(3, 0.1, [0.8, 0.3, 0.7], math.pi + 0.3), Marker(0)))[1]
    assert view.title == "View of the markers that face 17.2 deg to the right" and view.reference == ""


def test_page_1_says_where_the_default_markers_hang(tmp_path: Path) -> None:
    text = text_of(dock_of(DEFAULT_DOCK), 1, tmp_path)
    assert "Dock 'default': where its 3 markers (DICT_4X4_50) hang" in text
    # id, side, beside the middle, centre, upper edge (700 + 100/2 + 100/6 + 12), in front of the wall, faces
    for row in (
        "0 100 0 700 778.7 0 straight",
        "1 150 350 left 700 812 0 straight",
        "2 150 350 right 700 812 0 straight",
    ):
        assert row in text
    assert re.search(r"350 350\n", text), "from centre to centre"
    assert "--paper a4 --measured-bar" in text


def test_a_markers_page_says_where_it_hangs(tmp_path: Path) -> None:
    dock = dock_with(Marker(7, 0.0805, [0.9, -0.1234, 0.65]))
    text = text_of(replace(dock, name="Küche"), 3, tmp_path)
    assert "Dock 'Küche': marker 7 of DICT_4X4_50, side 80.5 mm" in text
    assert "its centre 650 mm above the floor, 123.4 mm right of the bay's middle" in text
    assert "UP" in text and "id 7 DICT_4X4_50" in text
    assert "centre 65.7 mm below upper edge" in text  # 80.5/2 + 80.5/6 + 12


def test_many_markers_and_an_open_dock(tmp_path: Path) -> None:
    """The table goes on, no marker is missing from it."""
    markers = [Marker(i, 0.05, [0.9, 0.08 * (i % 10) - 0.4, 0.3 + 0.08 * (i // 10)]) for i in range(50)]
    dock = replace(dock_with(*markers), bay=Bay(side_wall_length=0.0))
    document = document_of(dock)
    assert document.plan_pages == 3
    text = text_of(dock, 1, tmp_path) + text_of(dock, 2, tmp_path)
    assert [int(row) for row in re.findall(r"^ (\d+) 50 [\d.]+ ?(?:left|right)? ", text, re.MULTILINE)] == list(
        range(50)
    )
