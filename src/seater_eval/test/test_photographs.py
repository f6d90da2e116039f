"""perception_photographs: truth files, matching, the board as truth, table and bars, the command itself."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_common.marker_family import marker_family
from seater_common.params import ParameterError
from seater_eval.perception.images.scenes import normal_error
from seater_eval.photographs.board import board_of, leave_one_out
from seater_eval.photographs.detectors import Found
from seater_eval.photographs.measures import MarkerErrors, errors_on_board, match
from seater_eval.photographs.report import photograph_bars
from seater_eval.photographs.rows import shared_with
from seater_eval.photographs.truth import KnownMarker, Photograph, PhotographFolder, load_folders
from seater_eval.photographs.unlisted import with_unlisted

ROOT = Path(__file__).resolve().parents[3]
K = np.array([[600.0, 0.0, 319.5], [0.0, 600.0, 239.5], [0.0, 0.0, 1.0]])
SIDE, SQUARES = 0.7, (5, 4)  # [squares], a chessboard with markers in every second square
WHITE = [(x, y) for y in range(SQUARES[1]) for x in range(SQUARES[0]) if (x + y) % 2]
CENTERS = {i: np.array([x + 0.5, y + 0.5]) for i, (x, y) in enumerate(WHITE)}
TURN, PLACE = cv2.Rodrigues(np.array([0.35, -0.3, 0.1]))[0], np.array([-2.3, -1.8, 7.0])  # y of the board goes down


def seen(at: np.ndarray) -> np.ndarray:
    """Points of the board (n, 2) in the image [px]."""
    points = np.column_stack([at, np.zeros(len(at))]) @ TURN.T + PLACE
    return (points @ K.T)[:, :2] / points[:, 2:]


def corners(i: int) -> np.ndarray:
    return seen(CENTERS[i] + SIDE * np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]))


def photograph(path: Path = Path("none")) -> Photograph:
    markers = tuple(KnownMarker(id=i, center=corners(i).mean(axis=0), side=60.0) for i in CENTERS)
    return Photograph(path=path, width=640, height=480, K=K, D=np.zeros(5), markers=markers)


def draw(folder: Path) -> None:
    """A photograph of the board and its truth.json."""
    scale = 400
    page = np.full((scale * SQUARES[1], scale * SQUARES[0]), 215, np.uint8)
    family = marker_family("DICT_4X4_50")
    for i, at in CENTERS.items():
        side = round(SIDE * scale)
        x, y = np.rint(at * scale - 0.5 * side).astype(int)
        drawn = cv2.resize(family.image(i, 6 * side), (side, side), interpolation=cv2.INTER_AREA)
        page[y : y + side, x : x + side] = np.where(drawn > 127, 215, 40)
    square = np.array([[0, 0], [SQUARES[0], 0], SQUARES, [0, SQUARES[1]]], float)
    H = cv2.getPerspectiveTransform((square * scale - 0.5).astype(np.float32), seen(square).astype(np.float32))
    to_samples = np.array([[4.0, 0.0, 1.5], [0.0, 4.0, 1.5], [0.0, 0.0, 1.0]])  # 4 x 4 in each pixel
    image = cv2.warpPerspective(page, to_samples @ H, (2560, 1920), flags=cv2.INTER_NEAREST, borderValue=150)
    image = cv2.resize(image, (640, 480), interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(folder / "00.png"), cv2.GaussianBlur(image, (0, 0), 0.7))
    markers = [{"id": m.id, "center": m.center.tolist(), "side": m.side} for m in photograph().markers]
    image_truth = {"width": 640, "height": 480, "K": K.ravel().tolist(), "D": [0.0] * 5, "markers": markers}
    truth = {"dictionary": "DICT_4X4_50", "images": {"00.png": image_truth}, "board_marker_side": SIDE}
    truth["board_marker_centers"] = {str(i): at.tolist() for i, at in CENTERS.items()}
    (folder / "truth.json").write_text(json.dumps(truth))


def test_matching_asks_for_id_and_place() -> None:
    there = Found(id=1, corners=corners(1))
    elsewhere, unknown = Found(id=2, corners=corners(3)), Found(id=40, corners=corners(4))
    matched = match(photograph(), [there, Found(id=1, corners=corners(1)), elsewhere, unknown])
    assert list(matched.found) == [1]
    assert [f.id for f in matched.false] == [1, 2, 40]
    assert [m.id for m in matched.missed] == [i for i in CENTERS if i != 1]


def test_a_marker_at_its_place_on_the_board_is_not_false_for_being_unlisted() -> None:
    listed = photograph()
    hidden, elsewhere = sorted(CENTERS)[-2:]
    shown = replace(listed, markers=tuple(m for m in listed.markers if m.id not in (hidden, elsewhere)))
    finds = [
        Found(id=hidden, corners=corners(hidden)),
        Found(id=elsewhere, corners=corners(elsewhere) + 60.0),
        Found(id=40, corners=corners(elsewhere)),
    ]
    by_board = PhotographFolder(name="a", dictionary="DICT_4X4_50", photographs=(shown,), board=CENTERS)
    by_another = replace(by_board, photographs=(shown, listed), board={})
    for folder in (by_board, by_another):
        matched = with_unlisted(folder, shown, match(shown, finds))
        assert [f.id for f in matched.unlisted] == [hidden]
        assert [f.id for f in matched.false] == [elsewhere, 40]
    assert len(with_unlisted(replace(by_board, board={}), shown, match(shown, finds)).false) == 3


@pytest.mark.parametrize("side", [SIDE, None])
def test_board_is_the_truth_of_the_marker_left_out(side: float | None) -> None:
    """Its own corners play no part; turned markers and an unknown side follow from the others."""
    found = {i: np.roll(corners(i), 1, axis=0) for i in CENTERS}  # prints turned by a quarter on the board
    board = board_of(CENTERS, [(photograph(), found)], side)
    assert board is not None
    wrong = {**found, 4: found[4] + [0.7, 0.0]}
    truth = leave_one_out(board, photograph(), wrong, 4)
    assert truth is not None
    assert truth.corners == pytest.approx(found[4], abs=0.01)
    normal = np.eye(4)
    normal[:3, 2] = -TURN[:, 2]  # out of the paper, towards the camera
    assert normal_error(truth.pose, normal) < 1e-3
    assert np.linalg.det(truth.pose[:3, :3]) == pytest.approx(1.0)


def test_bent_board_is_no_truth() -> None:
    random = np.random.default_rng(1)
    found = {i: corners(i) + random.normal(0.0, 3.0, (1, 2)) for i in CENTERS}
    board = board_of(CENTERS, [(photograph(), {i: corners(i) for i in CENTERS})], SIDE)
    assert board is not None
    assert leave_one_out(board, photograph(), found, 4) is None


def test_normalised_errors_are_those_of_the_covariance() -> None:
    """A pose drawn from its covariance: 6 of the pose, 2 of each corner, on average."""
    exact = {i: corners(i) for i in CENTERS}
    board = board_of(CENTERS, [(photograph(), exact)], SIDE)
    assert board is not None
    truth = leave_one_out(board, photograph(), exact, 4)
    assert truth is not None
    random = np.random.default_rng(2)
    sd = np.array([2e-3, 2e-3, 2e-2, 5e-3, 5e-3, 2e-3])
    of_pose, of_corners = [], []
    for _ in range(300):
        off, pose = sd * random.standard_normal(6), truth.pose.copy()
        pose[:3, 3] -= off[:3]
        pose[:3, :3] = cv2.Rodrigues(-off[3:])[0] @ pose[:3, :3]
        four = Found(id=4, corners=exact[4], pose=pose, covariance=np.diag(sd**2))
        found = {i: Found(id=i, corners=c) for i, c in exact.items()} | {4: four}
        (error,) = [e for e in errors_on_board(board, photograph(), found) if e.id == 4]
        assert error.nees is not None and error.corner_nees is not None
        of_pose.append(error.nees)
        of_corners.append(error.corner_nees)
    assert np.mean(of_pose) == pytest.approx(6.0, rel=0.15)
    assert np.mean(of_corners) == pytest.approx(2.0, rel=0.15)


def marker_errors(i: int) -> MarkerErrors:
    """Of marker i where it is."""
    exact = {k: Found(id=k, corners=corners(k)) for k in CENTERS}
    board = board_of(CENTERS, [(photograph(), {k: f.corners for k, f in exact.items()})], SIDE)
    assert board is not None
    (error,) = [e for e in errors_on_board(board, photograph(), exact) if e.id == i]
    return error


def test_shrunk_markers_show_as_inwards() -> None:
    found = {i: Found(id=i, corners=corners(i)) for i in CENTERS}
    found[4] = Found(id=4, corners=0.98 * corners(4) + 0.02 * corners(4).mean(axis=0))
    board = board_of(CENTERS, [(photograph(), {i: corners(i) for i in CENTERS})], SIDE)
    assert board is not None
    (error,) = [e for e in errors_on_board(board, photograph(), found) if e.id == 4]
    assert error.inwards == pytest.approx(0.02 * np.linalg.norm(corners(4) - corners(4).mean(axis=0), axis=1).mean())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"dictionary": None}, "dictionary"),
        ({"images": {"gone.png": {}}}, "gone.png"),
        ({"board_marker_side": "wide"}, "wide"),
    ],
)
def test_wrong_truth_is_named(tmp_path: Path, change: dict, words: str) -> None:
    draw(tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text()) | change
    (tmp_path / "truth.json").write_text(json.dumps({k: v for k, v in truth.items() if v is not None}))
    with pytest.raises(ParameterError, match=words) as error:
        load_folders(tmp_path)
    assert "truth.json" in str(error.value)


def test_no_truth_is_named(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"no truth\.json"):
        load_folders(tmp_path)


def test_bars_count_all_markers_and_name_the_worst_folder() -> None:
    nothing = {"on_board": 0, "certain": 0, "wrong_and_certain": 0, "false": 0}
    counts = {("a", "seater"): 99, ("a", "opencv_default"): 100, ("b", "seater"): 97, ("b", "opencv_default"): 90}
    rows = [{"folder": f, "detector": d, "markers": 100, "found": n, **nothing} for (f, d), n in counts.items()]
    bars = {bar.name: bar for bar in photograph_bars({"rows": rows})}
    assert bars["recall, all folders"].value == pytest.approx(0.98)
    assert bars["recall, worst folder"].value == pytest.approx(0.97)
    assert bars["recall behind OpenCV's, worst folder"].value == pytest.approx(0.01)
    assert not bars["recall behind OpenCV's, worst folder"].met
    assert not bars["wrong branch called certain"].met  # nothing was measured


def test_corners_are_compared_on_shared_markers() -> None:
    """Ours are 0.3 px off on marker 1, the peer's 0.2; marker 2 has only ours, 3 px off."""

    def errors(lengths: dict[int, float]) -> dict:
        return {("00.png", i): replace(marker_errors(i), corners=(e,) * 4) for i, e in lengths.items()}

    shared = shared_with(errors({1: 0.2}), errors({1: 0.3, 2: 3.0}))
    assert shared["markers"] == 1
    assert (shared["ours"]["median"], shared["theirs"]["median"]) == pytest.approx((0.3, 0.2))


def test_bars_beside_peers_take_the_best_one() -> None:
    def row(detector: str, milliseconds: float, shared: dict) -> dict:
        counts = {"markers": 100, "found": 99, "false": 0, "certain": 0, "wrong_and_certain": 0, "on_board": 99}
        spread = {"median": 0.3, "p99": 0.9, "mean": 6.0}
        errors = {"corner_px": spread, "nees": spread, "shared": shared, "milliseconds": {"median": milliseconds}}
        return {"folder": "a", "detector": detector, **counts, **errors}

    def beside(markers: int, median: float, p99: float) -> dict:
        ours = {"median": 0.3, "p99": 0.9}
        return {"markers": markers, "ours": ours, "theirs": {"median": median, "p99": p99}}

    rows = [row("seater", 9.0, {}), row("opencv_default", 11.0, {}), row("opencv_none", 10.0, {})]
    rows += [row("locus", 1.0, beside(50, 0.25, 3.0)), row("rapidtag", 1.0, beside(50, 0.6, 1.0))]
    rows += [row("opencv5", 1.0, beside(3, 0.01, 0.01))]  # too few markers to tell
    bars = {bar.name: bar for bar in photograph_bars({"rows": rows})}
    median, p99 = (bars[f"a: corner error, {m} / best peer's"] for m in ("median", "p99"))
    assert (median.value, median.note) == (pytest.approx(1.2), "locus")
    assert (p99.value, p99.note) == (pytest.approx(0.9), "rapidtag")
    assert bars["a: time / plain OpenCV's"].value == pytest.approx(0.9)


def test_command_on_a_drawn_photograph(tmp_path: Path) -> None:
    """All markers are found, corners are exact, a marker that is said to be there and is not is missed."""
    draw(tmp_path)
    truth = json.loads((tmp_path / "truth.json").read_text())
    truth["images"]["00.png"]["markers"].append({"id": 44, "center": [50.0, 50.0], "side": 40.0})
    (tmp_path / "truth.json").write_text(json.dumps(truth))
    words = [sys.executable, str(ROOT / "src/seater_eval/nodes/perception/perception_photographs"), str(tmp_path)]
    options = ["--config", str(ROOT / "config"), "--results", str(tmp_path / "results")]
    ended = subprocess.run([*words, *options], capture_output=True, text=True, timeout=120)
    assert ended.returncode == 1, ended.stderr  # recall is 10 of 11
    results = json.loads((tmp_path / "results/perception_photographs.json").read_text())
    row = results["rows"][0]
    assert (row["markers"], row["found"], row["false"]) == (len(CENTERS) + 1, len(CENTERS), 0)
    assert row["on_board"] == len(CENTERS)
    assert row["corner_px"]["max"] < 0.25
    assert row["board_marker_side"] == pytest.approx(SIDE)
    assert cv2.imread(str(tmp_path / "results/perception_photographs.png")) is not None
    wrong = subprocess.run([*words[:2], str(tmp_path / "results")], capture_output=True, text=True, timeout=120)
    assert wrong.returncode == 2
    assert "no truth.json" in wrong.stderr
