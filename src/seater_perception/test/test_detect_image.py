"""The command detect_image, on files that this test draws."""

from __future__ import annotations

import json
import math
import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

import seater_perception as sp

CONFIG = Path(__file__).resolve().parents[3] / "config"
CAMERA = CONFIG / "cameras" / "d455.yaml"  # f = 640 px, 1280 x 720
# Beside the binding in devel and install space: lib/python3/dist-packages and lib/seater_perception.
COMMAND = Path(sp.__file__).resolve().parents[2] / "seater_perception" / "detect_image"
F = 640.0


def drawn(prints: dict[tuple[int, int], tuple[str, int]], side: int = 128) -> np.ndarray:
    """720 x 1280: frontal prints of (dictionary, id), their first pixel at (u, v), `side` px wide."""
    image = np.full((720, 1280), 215, np.uint8)
    for (u, v), (dictionary, number) in prints.items():
        family = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
        black = cv2.aruco.drawMarker(family, number, side) < 128
        image[v : v + side, u : u + side] = np.where(black, 40, 215)
    return cv2.GaussianBlur(image, (0, 0), 0.8)


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([str(COMMAND), *map(str, arguments)], capture_output=True, text=True, timeout=120)


def found(*arguments: object) -> list[dict[str, Any]]:
    """One object per line."""
    done = run("--json", *arguments)
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def corners_at(u: int, v: int, side: int = 128) -> np.ndarray:
    """The first pixel's outer edge is half a pixel before its centre."""
    low, high = np.array([u, v]) - 0.5, np.array([u, v]) - 0.5 + side
    return np.array([low, [high[0], low[1]], high, [low[0], high[1]]])


@pytest.fixture
def image(tmp_path: Path) -> Path:
    path = tmp_path / "image.png"
    cv2.imwrite(str(path), drawn({(500, 300): ("DICT_4X4_50", 3)}))
    return path


DICTIONARY = ("--dictionary", "DICT_4X4_50")


def test_without_a_size_it_says_where_markers_are(image: Path, tmp_path: Path) -> None:
    (result,) = found(*DICTIONARY, "--draw", tmp_path, image)
    (marker,) = result["markers"]
    assert marker["id"] == 3
    assert np.abs(np.array(marker["corners"]) - corners_at(500, 300)).max() < 0.1
    assert marker["side_px"] == pytest.approx(128, abs=0.1)
    assert "position" not in marker and result["dock"] == []
    assert result["time"]["detection"] > 0.0 and result["time"]["reading"] > 0.0
    assert cv2.imread(result["drawing"]).shape == (720, 1280, 3)
    assert "    3    128.0  (499.5" in run(*DICTIONARY, image).stdout


def test_a_field_of_view_gives_approximate_poses(image: Path) -> None:
    fov = 2.0 * math.degrees(math.atan(640.0 / 500.0))  # f = 500 px
    (result,) = found("--fov", fov, *DICTIONARY, "--size", 0.1, image)
    assert result["approximate"] is True and result["assumed_fov"] == pytest.approx(math.radians(fov))
    assert result["markers"][0]["position"][2] == pytest.approx(0.1 * 500.0 / 128.0, rel=2e-3)
    assert "approximate: no calibration, a field of view of 104.0 deg" in (
        run("--fov", fov, *DICTIONARY, "--size", 0.1, image).stdout
    )
    (exact,) = found("--camera", CAMERA, *DICTIONARY, "--size", 0.1, image)
    assert exact["approximate"] is False and "assumed_fov" not in exact
    assert exact["markers"][0]["position"][2] == pytest.approx(0.1 * F / 128.0, rel=2e-3)


def turned(z: float, yaw: float, noise: float) -> np.ndarray:
    """Marker 3, 0.1 m wide, straight ahead at z [m], turned about the vertical; drawn at eight times the resolution."""
    fine = 8
    black = cv2.aruco.drawMarker(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50), 3, 240) < 128
    sheet = np.pad(np.where(black, 60.0, 180.0), 60, constant_values=180.0)  # 0.15 m
    corners = 0.075 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    depth = z + corners[:, 0] * math.sin(yaw)
    seen = F * np.column_stack([corners[:, 0] * math.cos(yaw), corners[:, 1]]) / depth[:, None]
    pixels = fine * (seen + [79.5, 79.5]) + 0.5 * (fine - 1)
    on_sheet = 360.0 * (corners / 0.15 + 0.5) - 0.5
    H = cv2.getPerspectiveTransform(on_sheet.astype(np.float32), pixels.astype(np.float32))
    patch = cv2.warpPerspective(sheet, H, (160 * fine, 160 * fine), borderValue=180.0)
    image = np.full((720, 1280), 180.0)
    image[280:440, 560:720] = cv2.resize(patch, (160, 160), interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), 0.8) + np.random.default_rng(1).normal(0.0, noise, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def test_two_angles_that_explain_the_image_leave_the_distance(tmp_path: Path) -> None:
    """A small print, a little turned, in noise: nothing tells to which side. A large one is clear."""
    path, options = tmp_path / "a.png", ("--camera", CAMERA, *DICTIONARY, "--size", 0.1, tmp_path / "a.png")
    for z, yaw, noise, undecided in ((3.5, 0.12, 9.0, [3]), (1.2, 0.5, 2.0, [])):
        cv2.imwrite(str(path), turned(z, yaw, noise))
        (result,) = found(*options)
        assert result["distance_only"] == undecided
        assert result["markers"][0]["position"][2] == pytest.approx(z, rel=0.01)
        assert ("marker 3: only its distance is certain" in run(*options).stdout) == bool(undecided)


@pytest.mark.parametrize("bits", [10, 12, 14, 16])
def test_files_of_more_than_8_bits(tmp_path: Path, bits: int) -> None:
    """The low bits of 16, as cameras of 10 bits fill them; read as 8 bits, they would be nearly black."""
    deep = drawn({(500, 300): ("DICT_4X4_50", 3)}).astype(np.float64) * ((2**bits - 1) / 255.0)
    for name in ("a.png", "a.tiff"):
        cv2.imwrite(str(tmp_path / name), np.rint(deep).astype(np.uint16))
        (result,) = found(*DICTIONARY, tmp_path / name)
        assert np.abs(np.array(result["markers"][0]["corners"]) - corners_at(500, 300)).max() < 0.1


def test_floating_point_files_are_named(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.tiff"), np.zeros((50, 50), np.float32))
    done = run(*DICTIONARY, tmp_path / "a.tiff")
    assert done.returncode == 1 and "its pixels are of type CV_32FC1, must be whole numbers" in done.stderr


def with_orientation(jpeg: bytes, orientation: int) -> bytes:
    """The JPEG with an EXIF block of one entry, right after its start."""
    tiff = b"II*\0\x08\0\0\0" + b"\x01\0" + b"\x12\x01\x03\0\x01\0\0\0" + bytes([orientation, 0, 0, 0]) + b"\0\0\0\0"
    body = b"Exif\0\0" + tiff
    return jpeg[:2] + b"\xff\xe1" + (len(body) + 2).to_bytes(2, "big") + body + jpeg[2:]


def test_exif_orientation_is_honoured(tmp_path: Path) -> None:
    upright = drawn({(500, 300): ("DICT_4X4_50", 3)})
    for orientation, turn in ((3, cv2.ROTATE_180), (6, cv2.ROTATE_90_COUNTERCLOCKWISE)):
        path = tmp_path / f"{orientation}.jpg"
        stored = cv2.imencode(".jpg", cv2.rotate(upright, turn), [cv2.IMWRITE_JPEG_QUALITY, 98])[1].tobytes()
        path.write_bytes(with_orientation(stored, orientation))
        (result,) = found("--camera", CAMERA, *DICTIONARY, "--size", 0.1, path)
        assert result["turned_by_exif"] is True
        assert np.abs(np.array(result["markers"][0]["corners"]) - corners_at(500, 300)).max() < 0.1
        assert "turned as its EXIF orientation says" in run(*DICTIONARY, path).stdout
        (as_stored,) = found("--orientation", "stored", *DICTIONARY, path)
        assert as_stored["turned_by_exif"] is False
        first = np.array(as_stored["markers"][0]["corners"][0])
        expected = [779.5, 419.5] if orientation == 3 else [299.5, 779.5]  # where rotation takes (499.5, 299.5)
        assert np.abs(first - expected).max() < 0.1
    done = run("--orientation", "stored", "--camera", CAMERA, *DICTIONARY, "--size", 0.1, path)
    assert done.returncode == 1
    assert "is 720 x 1280, its calibration is for 1280 x 720: it is turned; --orientation" in done.stderr


# What the stored image is of the upright one, by the numbers of the EXIF standard.
STORED = {
    1: lambda image: image,
    2: lambda image: cv2.flip(image, 1),
    3: lambda image: cv2.flip(image, -1),
    4: lambda image: cv2.flip(image, 0),
    5: cv2.transpose,
    6: lambda image: cv2.rotate(image, cv2.ROTATE_90_COUNTERCLOCKWISE),
    7: lambda image: cv2.flip(cv2.transpose(image), -1),
    8: lambda image: cv2.rotate(image, cv2.ROTATE_90_CLOCKWISE),
}


def test_every_exif_orientation_comes_upright(tmp_path: Path) -> None:
    upright, paths = drawn({(500, 300): ("DICT_4X4_50", 3)}), []
    for orientation, turn in STORED.items():
        paths.append(tmp_path / f"{orientation}.jpg")
        stored = cv2.imencode(".jpg", turn(upright), [cv2.IMWRITE_JPEG_QUALITY, 98])[1].tobytes()
        paths[-1].write_bytes(with_orientation(stored, orientation))
    paths.append(tmp_path / "none.jpg")
    cv2.imwrite(str(paths[-1]), upright, [cv2.IMWRITE_JPEG_QUALITY, 98])
    results = found(*DICTIONARY, *paths)
    assert [r["turned_by_exif"] for r in results] == [False] + 7 * [True] + [False]
    for result in results:
        assert np.abs(np.array(result["markers"][0]["corners"]) - corners_at(500, 300)).max() < 0.1


@pytest.mark.parametrize(
    ("dictionary", "ids", "named"),
    [
        ("DICT_4X4_50", (3, 17), "DICT_4X4_50"),
        ("DICT_4X4_250", (3, 77), "DICT_4X4_100"),
        ("DICT_6X6_1000", (3, 701), "DICT_6X6_1000"),
        ("DICT_APRILTAG_36h11", (3, 501), "DICT_APRILTAG_36h11"),
        ("DICT_APRILTAG_16h5", (3, 11), "DICT_APRILTAG_16h5"),
        ("DICT_ARUCO_ORIGINAL", (3, 1001), "DICT_ARUCO_ORIGINAL"),
    ],
)
def test_any_says_which_dictionary(tmp_path: Path, dictionary: str, ids: tuple[int, int], named: str) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), drawn({(300, 300): (dictionary, ids[0]), (700, 300): (dictionary, ids[1])}))
    (result,) = found("--dictionary", "any", path)
    assert result["dictionary"] == named
    assert [m["id"] for m in result["markers"]] == list(ids)


def test_any_finds_several_dictionaries_and_poses(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    prints = {(100, 300): ("DICT_5X5_50", 1), (400, 300): ("DICT_5X5_50", 2), (800, 300): ("DICT_APRILTAG_36h11", 4)}
    cv2.imwrite(str(path), drawn(prints))
    first, second = found("--dictionary", "any", "--camera", CAMERA, "--size", 0.1, path)
    assert first["dictionary"] == "DICT_5X5_50" and [m["id"] for m in first["markers"]] == [1, 2]
    assert second["dictionary"] == "DICT_APRILTAG_36h11" and [m["id"] for m in second["markers"]] == [4]
    assert second["markers"][0]["position"][2] == pytest.approx(0.1 * F / 128.0, rel=2e-3)
    cv2.imwrite(str(path), np.full((720, 1280), 200, np.uint8))
    (nothing,) = found("--dictionary", "any", path)
    assert nothing["markers"] == [] and "dictionary" not in nothing


@pytest.mark.parametrize("text", ["%YAML:1.0\n---\nimage_width: 640\n", "{{ no: yaml", "bits: 4\n", "", "[1, 2]"])
def test_any_names_files_that_are_no_families(
    text: str, image: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stray = tmp_path / "families" / "camera.yml"
    stray.parent.mkdir()
    stray.write_text(text)
    monkeypatch.setenv("SEATER_MARKER_FAMILIES", str(stray.parent))
    done = run("--dictionary", "any", "--json", image)
    assert done.returncode == 0, done.stderr
    assert [m["id"] for m in json.loads(done.stdout)["markers"]] == [3]
    assert "warning: no marker family, left out: " in done.stderr and str(stray) in done.stderr
    (result,) = found(*DICTIONARY, image)  # who asks for another one need not know
    assert [m["id"] for m in result["markers"]] == [3]
    asked = run("--dictionary", "camera", image)
    assert asked.returncode == 2 and str(stray) in asked.stderr


def test_all_places_of_an_id_are_listed(tmp_path: Path) -> None:
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), drawn({(200, 300): ("DICT_4X4_50", 3), (800, 300): ("DICT_4X4_50", 3)}))
    (result,) = found(*DICTIONARY, path)
    assert [m["id"] for m in result["markers"]] == [3, 3]
    (result,) = found("--camera", CAMERA, *DICTIONARY, "--size", 0.1, path)
    assert result["markers"] == []
    assert sorted(round(m["corners"][0][0], 1) for m in result["repeated"]) == [199.5, 799.5]
    text = run("--camera", CAMERA, *DICTIONARY, "--size", 0.1, path).stdout
    assert "marker 3 stands at 2 places, so none of them is used; top left corners: (" in text and "(799.5, 299" in text


def test_files_of_opencv(tmp_path: Path, image: Path) -> None:
    """A calibration and a custom dictionary, both as FileStorage writes them."""
    camera = cv2.FileStorage(str(tmp_path / "camera.yml"), cv2.FILE_STORAGE_WRITE)
    camera.write("image_width", 1280)
    camera.write("image_height", 720)
    camera.write("camera_matrix", np.array([[500.0, 0.0, 639.5], [0.0, 500.0, 359.5], [0.0, 0.0, 1.0]]))
    camera.write("distortion_coefficients", np.zeros((5, 1)))
    camera.release()
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    family = cv2.FileStorage(str(tmp_path / "mine.yml"), cv2.FILE_STORAGE_WRITE)
    for key, value in (("nmarkers", 2), ("markersize", 4), ("maxCorrectionBits", 0)):
        family.write(key, value)
    for i, number in enumerate((7, 3)):
        bits = cv2.aruco.Dictionary_getBitsFromByteList(known.bytesList[number][None], 4)
        family.write(f"marker_{i}", "".join(map(str, bits.ravel())))
    family.release()
    options = ("--camera", tmp_path / "camera.yml", "--dictionary", tmp_path / "mine.yml", "--size", 0.1)
    (result,) = found(*options, image)
    assert [m["id"] for m in result["markers"]] == [1]
    assert result["markers"][0]["position"][2] == pytest.approx(0.1 * 500.0 / 128.0, rel=2e-3)


def test_what_is_refused_is_named(tmp_path: Path) -> None:
    """A marker of the dock, one of another, one too small, and a dark square; then a bar that none reaches."""
    image = drawn({(200, 300): ("DICT_4X4_50", 3), (600, 300): ("DICT_4X4_50", 9)})
    small = drawn({(50, 50): ("DICT_4X4_50", 5)}, side=96)[:200, :200]
    image[60:89, 1000:1029] = cv2.resize(small, (29, 29), interpolation=cv2.INTER_AREA)  # 14 px
    image[500:600, 300:400] = 40
    cv2.imwrite(str(tmp_path / "a.png"), image)
    marker = {"id": 3, "size": 0.1, "position": [1.0, 0.0, 0.7], "normal_yaw": 3.1}
    (tmp_path / "dock.yaml").write_text(yaml.safe_dump({"dictionary": "DICT_4X4_50", "markers": [marker]}))
    parameters = yaml.safe_load((CONFIG / "perception.yaml").read_text())
    parameters["detector"]["min_side"] = 16.0
    (tmp_path / "p.yaml").write_text(yaml.safe_dump(parameters))
    options = ("--camera", CAMERA, "--markers", tmp_path / "dock.yaml", "--parameters", tmp_path / "p.yaml")
    (result,) = found(*options, tmp_path / "a.png")
    assert [m["id"] for m in result["markers"]] == [3]
    why = {c["id"]: c for c in result["refused_candidates"]}
    assert why[9]["why"] == "the dock has no such id"
    assert np.abs(np.array(why[9]["corners"]) - corners_at(600, 300)).max() < 0.1
    assert "px is below detector/min_side, 16.0 px" in why[5]["why"]
    assert why[None]["why"] == "no code of the dictionary shows"
    assert np.abs(np.mean(why[None]["corners"], axis=0) - [349.5, 549.5]).max() < 1.0
    assert 3 not in why
    text = run(*options, tmp_path / "a.png").stdout
    assert "refused: what may be marker 9 at (599.5, 299.5): the dock has no such id" in text
    parameters["detector"] |= {"min_side": 11.0, "min_evidence": 20.0}
    (tmp_path / "p.yaml").write_text(yaml.safe_dump(parameters))
    (result,) = found(*DICTIONARY, "--parameters", tmp_path / "p.yaml", tmp_path / "a.png")
    assert result["markers"] == []
    why = {c["id"]: c["why"] for c in result["refused_candidates"]}
    assert "is too small (detector/min_evidence 20.0)" in why[3]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((), "no image given"),
        (("a.png",), "give --markers, or --dictionary"),
        (("--dictionary", "DICT_4X4_50", "--size", "0.1", "a.png"), "give --camera, or --fov"),
        (("--dictionary", "DICT_9X9", "a.png"), "--dictionary: is 'DICT_9X9', must be one of"),
        (("--fov", "300", "a.png"), "--fov: is 300, must be a number from 1 to 170"),
        (("--fov", "69", "--camera", CAMERA, *DICTIONARY, "a.png"), "--fov: not with --camera"),
        (("--dictionary", "any", "--markers", "d.yaml", "a.png"), "--dictionary any: not with --markers"),
        (("--orientation", "left", "a.png"), "--orientation: is 'left', must be one of exif, stored"),
        (("--sise", "0.1", "a.png"), "--sise: unknown option"),
    ],
)
def test_wrong_use_is_named(arguments: tuple[object, ...], text: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2 and text in done.stderr


def test_images_that_cannot_be_read_are_named_and_do_not_end_it(image: Path, tmp_path: Path) -> None:
    whole = cv2.imencode(".jpg", cv2.imread(str(image)))[1].tobytes()
    (tmp_path / "cut.jpg").write_bytes(whole[: len(whole) * 2 // 3])
    (tmp_path / "whole.jpg").write_bytes(whole + b"appended by a camera")
    (tmp_path / "folder").mkdir()
    wrong = {"none.png": "cannot be opened", tmp_path / "folder": "is a folder", tmp_path / "cut.jpg": "is cut off"}
    done = run(*DICTIONARY, *wrong, tmp_path / "whole.jpg", image)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        line for line in done.stderr.splitlines() if any(f"{name}: {text}" in line for name, text in wrong.items())
    ]
    assert len(done.stderr.splitlines()) == len(wrong) and done.stdout.count("    3    12") == 2


def test_a_drawing_takes_no_other_file_s_place(image: Path, tmp_path: Path) -> None:
    before = image.read_bytes()
    done = run(*DICTIONARY, "--draw", image.parent / "." / image.name, image)
    assert done.returncode == 2 and "the image itself" in done.stderr and image.read_bytes() == before
    (tmp_path / "a").mkdir()
    other = tmp_path / "a" / image.name
    cv2.imwrite(str(other), drawn({}))
    first, second = found(*DICTIONARY, "--draw", tmp_path, image, other)
    assert first["drawing"] != second["drawing"] and image.read_bytes() == before
    assert Path(first["drawing"]).read_bytes() != Path(second["drawing"]).read_bytes()
