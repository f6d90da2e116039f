"""Detectors from PyPI in processes of their own; a stand-in takes the place of the packages."""

import subprocess
import sys
import venv
from pathlib import Path

import cv2
import numpy as np
import pytest

from seater_eval.peers.catalogue import PEERS
from seater_eval.peers.process import PeerError, PeerProcess, peers_for
from seater_eval.peers.worker import MAKERS
from seater_eval.perception.peers import make_peer

ROOT = Path(__file__).resolve().parents[3]
# Finds id 7 round the brightest pixel; prints, as some libraries do; ends at an image without light.
STAND_IN = """
import os
import os
import numpy as np
CORNER_REFINE_SUBPIX = 1
class DetectorParameters:
    pass
def detect_markers(image, dictionary, parameters):
    assert parameters.corner_refinement_method == 1 and dictionary == "DICT_4X4_50"
    print("two minima")
    if not image.any():
        os._exit(3)
    y, x = np.unravel_index(image.argmax(), image.shape)
    return [[(x - 10, y - 10), (x + 10, y - 10), (x + 9, y + 10), (x - 9, y + 10)]], [7]
"""

NO_MARKERS = """{"dictionary": "DICT_4X4_50", "images": {"00.png": {"width": 64, "height": 48,
"K": [60, 0, 31.5, 0, 60, 23.5, 0, 0, 1], "D": [0, 0, 0, 0, 0], "markers": []}}}"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Like that of tools/make_peers.sh, with a `rapidtag` that is none."""
    path = tmp_path_factory.mktemp("peers")
    venv.create(path, system_site_packages=True)
    library = path / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
    (library / "rapidtag.py").write_text(STAND_IN)
    return path


def image_of(x: int, y: int) -> np.ndarray:
    image = np.zeros((48, 64), np.uint8)
    image[y, x] = 200
    return image


def test_what_the_process_finds_comes_back(folder: Path) -> None:
    peer = PeerProcess(folder, "rapidtag", "DICT_4X4_50")
    for x, y in ((20, 30), (33, 12)):
        answer = peer.look(image_of(x, y))
        ((id_, corners),) = answer.found
        assert id_ == 7
        np.testing.assert_array_equal(corners, [[x - 10, y - 10], [x + 10, y - 10], [x + 9, y + 10], [x - 9, y + 10]])
        assert answer.milliseconds >= 0.0


def test_a_peer_has_poses_by_its_corners(folder: Path) -> None:
    """About 19 px in the image's middle, f = 100 px, side 0.1 m: 0.53 m ahead, its front to the camera."""
    K = np.array([[100.0, 0.0, 32.0], [0.0, 100.0, 24.0], [0.0, 0.0, 1.0]])
    (seen,) = make_peer("rapidtag", K, 0.1, folder=folder)(image_of(32, 24))
    np.testing.assert_allclose(seen.pose[:3, 3], [0.0, 0.0, 0.52], atol=0.03)
    assert seen.pose[2, 2] < -0.5


def test_a_process_that_ends_is_named(folder: Path) -> None:
    peer = PeerProcess(folder, "rapidtag", "DICT_4X4_50")
    with pytest.raises(PeerError, match=r"rapidtag ended"):
        peer.look(np.zeros((48, 64), np.uint8))


def test_a_package_that_is_not_there_is_named(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(PeerError, match=r"locus.*make_peers\.sh"):
        PeerProcess(folder, "locus", "DICT_4X4_50")
    with pytest.raises(PeerError, match=r"is missing.*make_peers\.sh"):
        PeerProcess(tmp_path, "rapidtag", "DICT_4X4_50")
    with pytest.raises(PeerError, match="must be one of locus"):
        PeerProcess(folder, "napa", "DICT_4X4_50")


def test_every_peer_has_its_maker_and_its_dictionaries(folder: Path) -> None:
    assert set(MAKERS) == set(PEERS)
    assert peers_for("DICT_4X4_50", None) == ()
    assert "apriltag" not in peers_for("DICT_4X4_50", folder)
    assert peers_for("DICT_5X5_50", folder) == ("rapidtag", "opencv5", "opencv5_apriltag")


@pytest.mark.parametrize(
    "command",
    [
        "perception_accuracy",
        pytest.param("perception_range", marks=pytest.mark.extensive),
        pytest.param("perception_speed", marks=pytest.mark.extensive),
        "perception_photographs",
    ],
)
def test_commands_name_a_folder_without_peers(command: str, tmp_path: Path) -> None:
    words = [
        sys.executable,
        str(ROOT / "src/seater_eval/nodes/perception" / command),
        "--quick",
        "--config",
        str(ROOT / "config"),
    ]
    if command == "perception_photographs":
        (tmp_path / "truth.json").write_text(NO_MARKERS)
        cv2.imwrite(str(tmp_path / "00.png"), np.zeros((48, 64), np.uint8))
        words.append(str(tmp_path))
    words += ["--peers", str(tmp_path), "--results", str(tmp_path / "results")]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2, ended.stderr
    assert "tools/make_peers.sh" in ended.stderr
