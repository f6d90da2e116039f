"""What is printed and what perception looks for come from the same tables, for every dictionary that it knows."""

from __future__ import annotations

import numpy as np
import pytest
from printed import ROOT, dock_with, document_of

import seater_perception as sp
from seater_common.geometry import Marker
from seater_common.marker_family import marker_family
from seater_common.params import ParameterError


def names() -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SEATER_MARKER_FAMILIES", str(ROOT / "config" / "marker_families"))
        return list(sp.MarkerFamily.names())


@pytest.mark.parametrize("name", names())
def test_every_dictionary_of_perception_prints(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(ROOT / "config" / "marker_families"))
    known = sp.MarkerFamily.named(name)
    for marker_id in (0, len(known) // 2, len(known) - 2):
        piece = document_of(dock_with(Marker(marker_id), dictionary=name)).markers[0].piece
        pattern, cells = known.pattern(marker_id), known.cells  # rows of the pattern count from below
        wanted = [[pattern.at(column, cells - 1 - row) for column in range(cells)] for row in range(cells)]
        assert np.array_equal(piece.pattern, wanted)


def test_unknown_ids_are_all_named() -> None:
    with pytest.raises(ParameterError) as error:
        document_of(dock_with(Marker(50), Marker(3), Marker(99)))
    assert "dock.yaml/markers[0]/id: is 50, must be 0 to 49 (DICT_4X4_50)" in str(error.value)
    assert "markers[2]/id: is 99" in str(error.value) and "markers[1]" not in str(error.value)


def test_a_print_that_looks_the_same_upside_down_is_refused() -> None:
    assert np.array_equal(marker_family("DICT_ARUCO_ORIGINAL").codes[1023], [[0, 1, 1, 1, 0]] * 5)
    with pytest.raises(ParameterError, match=r"dock.yaml/markers\[0\]/id: is 1023, which looks the same when turned"):
        document_of(dock_with(Marker(1023), dictionary="DICT_ARUCO_ORIGINAL"))
