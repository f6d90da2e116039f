"""Somebody holds a board in front of the hidden lens until the command has enough views."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from seater_common.camera_model import CameraModel
from seater_tools.board.board import Board
from seater_tools.trial.board_views import placed, poses, rays_of, render, texture


class Photographer:
    """`take` first takes the views that the guide asks for; each time after, so many more at random places."""

    MORE = 8

    def __init__(self, lens: CameraModel, folder: Path, seed: int) -> None:
        self._lens, self._folder, self._rng = lens, folder, np.random.default_rng([seed, 42])
        self._board = Board()
        self._rays, self._drawn = rays_of(lens), texture(self._board)
        self.taken = 0

    def take(self) -> None:
        """Writes PNG files. Raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        asked = poses(self._board, self._lens) if self.taken == 0 else [self._drawn_pose() for _ in range(self.MORE)]
        for pose in asked:
            image = render(self._rays, pose, self._drawn, self.taken)
            path = self._folder / f"view_{self.taken:03d}.png"
            if not cv2.imwrite(str(path), image):
                raise OSError(f"cannot write {path}")
            self.taken += 1

    def _drawn_pose(self) -> np.ndarray:
        x, y = self._rng.uniform(-0.85, 0.85, 2)
        tilts = self._rng.uniform(-0.6, 0.6, 2)
        return placed(self._board, self._lens, x, y, self._rng.uniform(0.25, 0.42), *tilts, self._rng.uniform(0.0, 1.6))
