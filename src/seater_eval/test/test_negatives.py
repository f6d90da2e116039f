"""perception_negatives: which images and dictionaries count, what is false in them, the command itself."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_eval.negatives.images import has_one_of, names_of, negatives_in, read_grey
from seater_eval.negatives.report import describe_negatives, negative_bars

ROOT = Path(__file__).resolve().parents[3]
WANTED, OTHER = "DICT_4X4_50", "DICT_6X6_250"


def wall(*marks: tuple[str, int, int]) -> np.ndarray:
    """A grey wall (240 x 320) with prints (dictionary, id, left [px]) of 60 px on paper."""
    image = np.full((240, 320), 150, np.uint8)
    for dictionary, marker_id, left in marks:
        image[70:170, left : left + 100] = 215
        drawn = marker_family(dictionary).image(marker_id, 60)
        image[90:150, left + 20 : left + 80] = np.where(drawn > 127, 215, 40)
    return np.asarray(cv2.GaussianBlur(image, (0, 0), 0.7), dtype=np.uint8)


def write(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), image)


def run(*words: str) -> subprocess.CompletedProcess[str]:
    command = ROOT / "src/seater_eval/nodes/perception/perception_negatives"
    all_words = [sys.executable, str(command), "--config", str(ROOT / "config"), "--workers", "1", *words]
    return subprocess.run(all_words, capture_output=True, text=True, timeout=120)


def test_each_image_counts_once_and_what_shows_markers_can_be_left_out(tmp_path: Path) -> None:
    write(tmp_path / "a.png", wall())
    write(tmp_path / "below" / "copy.png", wall())
    write(tmp_path / "below" / "other.PNG", wall((OTHER, 3, 40)))
    write(tmp_path / "below" / "shows.png", wall((WANTED, 3, 40)))
    (tmp_path / "text.txt").write_text("no image")
    found = negatives_in([tmp_path], [WANTED], ["*/shows.*"])
    assert [n.path.name for n in found] == ["a.png", "other.PNG"]
    assert {n.dictionaries for n in found} == {(WANTED,)}
    with pytest.raises(ParameterError, match="is no folder"):
        negatives_in([tmp_path / "gone"], [WANTED], [])


def test_beside_a_truth_its_dictionary_is_not_looked_for(tmp_path: Path) -> None:
    """Nor one that holds the same codes."""
    write(tmp_path / "00.png", wall((WANTED, 3, 40)))
    marker = {"id": 3, "center": [90.0, 120.0], "side": 60.0}
    image = {"width": 320, "height": 240, "K": np.eye(3).ravel().tolist(), "D": [0.0] * 5, "markers": [marker]}
    (tmp_path / "truth.json").write_text(json.dumps({"dictionary": WANTED, "images": {"00.png": image}}))
    (negative,) = negatives_in([tmp_path], [WANTED, "DICT_4X4_1000", OTHER], [])
    assert negative.dictionaries == (OTHER,)


def test_codes_are_compared_in_all_four_turns(tmp_path: Path) -> None:
    code = marker_family(WANTED).codes[7]
    turned = tmp_path / "turned.yaml"
    lines = ["".join(map(str, row)) for row in np.rot90(code)]
    turned.write_text(f"bits: 4\nborder: 1\ncorrectable_bits: 0\ncodes:\n  - {' '.join(lines)!r}\n")
    assert has_one_of(str(turned), WANTED, [6, 7])
    assert not has_one_of(str(turned), WANTED, [6])


def test_dictionaries_by_name(tmp_path: Path) -> None:
    assert names_of([WANTED, OTHER, WANTED]) == (WANTED, OTHER)
    assert len(names_of(["all"])) == 21
    with pytest.raises(ParameterError, match=r"--dictionary.*DICT_9X9"):
        names_of(["DICT_9X9"])


def test_large_images_are_averaged_and_small_ones_left(tmp_path: Path) -> None:
    write(tmp_path / "large.png", np.tile(np.array([[0, 100], [100, 200]], np.uint8), (240, 320)))
    large = read_grey(tmp_path / "large.png", 320)
    assert large is not None and large.shape == (240, 320) and set(large.ravel()) == {100}
    write(tmp_path / "icon.png", wall()[:63])
    assert read_grey(tmp_path / "icon.png", 1920) is None


def test_table_says_what_the_number_of_images_proves() -> None:
    """0 of 1000: 1 - 0.05^(1 / 1000), 1 in 334."""
    rows = [{"dictionary": WANTED, "images": 1000, "false": 0}]
    data = {"images": 1000, "megapixels": 9.0, "unread": ["a"], "rows": rows, "false": []}
    assert "1 in 334" in describe_negatives(data) and "1 could not be read" in describe_negatives(data)
    assert negative_bars(data)[0].met
    find = {"image": "a.png", "dictionary": WANTED, "id": 17}
    assert "a.png: id 17" in describe_negatives({**data, "false": [find]})
    assert not negative_bars({**data, "false": [find]})[0].met
    assert not negative_bars({**data, "images": 0})[0].met


def test_command_counts_finds_of_the_dictionaries_asked_for(tmp_path: Path) -> None:
    """Marks of other dictionaries are none; a marker that nobody said is there is found, drawn and fails the bar."""
    write(tmp_path / "images" / "a.png", wall((OTHER, 3, 20), ("DICT_APRILTAG_36h11", 4, 180)))
    write(tmp_path / "images" / "b.png", wall((WANTED, 3, 20), (OTHER, 4, 180)))
    (tmp_path / "images" / "c.png").write_bytes(b"no image")
    results = tmp_path / "results"
    ended = run(str(tmp_path / "images"), "--results", str(results))
    assert ended.returncode == 1, ended.stderr
    data = json.loads((results / "perception_negatives.json").read_text())
    assert [(Path(f["image"]).name, f["dictionary"], f["id"]) for f in data["false"]] == [("b.png", WANTED, 3)]
    assert np.mean(data["false"][0]["corners"], axis=0) == pytest.approx([69.5, 119.5], abs=1.0)
    assert data["images"] == 2 and data["rows"] == [{"dictionary": WANTED, "images": 2, "false": 1}]
    assert [Path(p).name for p in data["unread"]] == ["c.png"]
    sheet = cv2.imread(str(results / "perception_negatives.png"))
    assert sheet is not None and sheet.min() < 60
    ended = run(str(tmp_path / "images"), "--results", str(results), "--without", "*/b.png", "--dictionary", WANTED)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    ended = run(str(tmp_path / "images"), "--results", str(results), "--dictionary", "DICT_9X9")
    assert ended.returncode == 2 and "DICT_9X9" in ended.stderr
