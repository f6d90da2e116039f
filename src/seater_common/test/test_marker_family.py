"""Marker families: OpenCV's as OpenCV draws them, and families of files."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_common.marker_family import load_family, marker_family, predefined_names
from seater_common.params import ParameterError

SMALL = """
bits: 3
border: 1
correctable_bits: 0
codes:
  - "110 010 001"
  - "101 100 110"
"""


@pytest.mark.parametrize("name", predefined_names())
def test_it_is_what_opencv_draws(name: str) -> None:
    family, dictionary = marker_family(name), cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    assert (len(family), family.bits, family.border) == (len(dictionary.bytesList), dictionary.markerSize, 1)
    assert np.array_equal(family.dictionary().bytesList, dictionary.bytesList)
    assert family.dictionary().maxCorrectionBits == dictionary.maxCorrectionBits
    for marker_id in (0, len(family) - 1):
        assert np.array_equal(family.image(marker_id, 180), cv2.aruco.drawMarker(dictionary, marker_id, 180))
        drawn = cv2.aruco.drawMarker(dictionary, marker_id, family.cells)
        assert np.array_equal(255 * family.print_of(marker_id), drawn)


def test_a_file_is_found_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "small.yaml").write_text(SMALL.replace("border: 1", "border: 2"))
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", f"/does/not/exist:{tmp_path}")
    family = marker_family("small")
    assert (family.name, len(family), family.bits, family.cells) == ("small", 2, 3, 7)
    assert family.print_of(0)[2:5, 2:5].tolist() == [[1, 1, 0], [0, 1, 0], [0, 0, 1]]
    assert family.print_of(0).sum() == 4
    assert np.array_equal(marker_family(str(tmp_path / "small.yaml")).codes, family.codes)


def test_a_dictionary_of_opencv_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known = marker_family("5X5_50")
    assert known.name == "DICT_5X5_50"
    file = cv2.FileStorage(str(tmp_path / "custom.yml"), cv2.FILE_STORAGE_WRITE)
    for key, value in (("nmarkers", len(known)), ("markersize", 5), ("maxCorrectionBits", 3)):
        file.write(key, value)
    for i, code in enumerate(known.codes):
        file.write(f"marker_{i}", "".join(map(str, code.ravel())))
    file.release()
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(tmp_path))
    family = marker_family("custom")
    assert np.array_equal(family.codes, known.codes)
    assert (family.border, family.correctable_bits) == (1, 3)
    (tmp_path / "custom.yml").write_text("nmarkers: 2\nmarkersize: 3\nmaxCorrectionBits: 0\nmarker_0: '110010001'\n")
    with pytest.raises(ParameterError, match=r"custom.yml: is no dictionary of OpenCV: 'marker_1' is missing"):
        marker_family("custom")


def test_the_recommended_family_of_aruco(monkeypatch: pytest.MonkeyPatch) -> None:
    """As published: 250 codes that differ by at least 12 bits, in any orientation."""
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(Path(__file__).resolve().parents[3] / "config/marker_families"))
    codes = marker_family("ARUCO_MIP_36h12").codes
    assert codes.shape == (250, 6, 6)
    for turn in range(4):
        distances = np.sum(codes[:, None] != np.rot90(codes, turn, (1, 2))[None], axis=(2, 3))
        least = distances if turn else distances + 36 * np.eye(250, dtype=int)
        assert least.min() >= 12


@pytest.mark.parametrize("marker_id", [-1, 50])
def test_an_unknown_id_is_refused(marker_id: int) -> None:
    with pytest.raises(ValueError, match=rf"markers: id {marker_id} is not in DICT_4X4_50 \(0\.\.49\)"):
        marker_family("DICT_4X4_50").print_of(marker_id)


@pytest.mark.parametrize("name", ["DICT_9X9", "detectMarkers", "../small", ""])
def test_an_unknown_name_is_refused(name: str) -> None:
    with pytest.raises(ParameterError, match=r"dictionary: is .*, must be one of DICT_"):
        marker_family(name)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("bits: 3", "bits: 9", r"small\.yaml/bits: is 9"),
        ("border: 1", "", r"small\.yaml/border: is missing"),
        ("border: 1", "border: 1\ncolour: red", r"small\.yaml/colour: unknown key"),
        ('"110 010 001"', "110010001", r"codes\[0\]: is 110010001, must be of type str"),
        ("110 010 001", "110 010 00", r"codes\[0\]: is '110 010 00', must be a text of 9 bits"),
        ("110 010 001", "110 010 002", r"codes\[0\]"),
        ("bits: 3", "bits: [", "cannot read"),
    ],
)
def test_a_wrong_file_says_what_is_wrong(tmp_path: Path, old: str, new: str, problem: str) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL.replace(old, new))
    with pytest.raises(ParameterError, match=problem):
        load_family(path)


def test_a_file_without_codes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "none.yaml"
    path.write_text("{bits: 3, border: 1, correctable_bits: 0, codes: []}")
    with pytest.raises(ParameterError, match="codes: is empty"):
        load_family(path)
