"""Views from a stream: kept are those that are new and still, and what is missing is said."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from boards import SIZE, camera

from seater_tools.board.board import Board
from seater_tools.trial.board_views import poses, rays_of, render, texture

collect = pytest.importorskip("seater_tools.ros.collect")


def test_new_and_still_views_are_kept(tmp_path: Path) -> None:
    board = Board()
    lens = camera("plumb_bob", (-0.2, 0.05, 0.0, 0.0, 0.0))
    rays, drawn = rays_of(lens), texture(board)
    at = [render(rays, pose, drawn) for pose in poses(board, lens)[:2]]
    collector = collect.Collector(board, tmp_path)
    # The first sight may be a blurred one; the second of the same place is kept, the third says nothing new; the board
    # moves and stops elsewhere.
    kept = [collector.look(image) for image in (at[0], at[0], at[0], at[1], at[1])]
    assert kept == [False, True, False, False, True]
    assert not collector.look(np.full(SIZE[::-1], 140, np.uint8))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["view_000.png", "view_001.png"]
    assert np.array_equal(cv2.imread(str(tmp_path / "view_001.png"), cv2.IMREAD_GRAYSCALE), at[1])
    assert collector.missing[0] == "13 more views that differ from each other"
