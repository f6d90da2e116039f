"""Somebody holds a board in front of the hidden lens until the command has enough views."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_tools.board.board import Board
from seater_tools.trial.board_views import placed, poses, rays_of, render, texture

Array = NDArray[np.float64]

EACH = 3  # views for each thing that is asked for
FEWEST = 8  # views each time: the others anywhere
FAR, NEAR = (0.28, 0.4), (0.16, 0.18)  # [m], see `board_views.poses`
REACH = 0.85  # of the way from the image's middle to its edge, where the board's middle is held
TILT = 0.55  # [rad]


class Photographer:
    """`take` first takes views everywhere, as the how-to has them; then those that the guide's words ask for."""

    def __init__(self, lens: CameraModel, folder: Path, seed: int) -> None:
        self._lens, self._folder, self._rng = lens, folder, np.random.default_rng([seed, 42])
        self._board = Board()
        self._rays, self._drawn = rays_of(lens), texture(self._board)
        self.taken = 0

    def take(self, said: str = "") -> None:
        """Writes PNG files; `said`: what the command has answered to those so far. Raises OSError."""
        self._folder.mkdir(parents=True, exist_ok=True)
        for pose in poses(self._board, self._lens) if self.taken == 0 else self._asked(said):
            image = render(self._rays, pose, self._drawn, self.taken)
            path = self._folder / f"view_{self.taken:03d}.png"
            if not cv2.imwrite(str(path), image):
                raise OSError(f"cannot write {path}")
            self.taken += 1

    def _asked(self, said: str) -> list[Array]:
        """Poses of the board."""
        views = [pose for line in said.splitlines() for pose in self._for(line)]
        return [*views, *(self._anywhere() for _ in range(FEWEST - len(views)))]

    def _for(self, line: str) -> list[Array]:
        """What somebody does who reads this line; nothing where it asks for nothing."""
        place = re.search(r"the board at the ((?:upper|lower|left|right)[a-z ]*) of the image", line)
        if place:
            x, y = _ways(place[1])
            return [self._held(REACH * x, REACH * y) for _ in range(EACH)]
        tilted = re.search(r"tilted .*its (upper|lower|left|right) edge towards the camera", line)
        if tilted:
            x, y = _ways(tilted[1])
            return [self._held(0.0, 0.0, tilts=(-TILT * y, TILT * x)) for _ in range(EACH)]
        if "tilt more" in line:
            return [self._held(0.0, 0.0, tilts=(way * TILT, 0.0)) for way in (-1, 1)] + [
                self._held(0.0, 0.0, tilts=(0.0, way * TILT)) for way in (-1, 1)
            ]
        if "the board near" in line:
            return [self._held(0.0, 0.0, distance=NEAR) for _ in range(EACH)]
        return []

    def _anywhere(self) -> Array:
        x, y = self._rng.uniform(-REACH, REACH, 2)
        return self._held(x, y, tilts=self._rng.uniform(-0.6, 0.6, 2), turned=1.6)

    def _held(
        self,
        x: float,
        y: float,
        distance: tuple[float, float] = FAR,
        tilts: tuple[float, float] | Array = (0.0, 0.0),
        turned: float = 0.3,
    ) -> Array:
        """With its middle about at (x, y) of the image [-1, 1], as it is seen there; a hand is nowhere exact."""
        rng, lens = self._rng, self._lens
        half = 0.5 * np.array([lens.width, lens.height])
        pixel = half * (1.0 + np.clip([x, y] + rng.uniform(-0.06, 0.06, 2), -0.92, 0.92))
        seen = lens.ray(pixel[None])[0] * float(lens.K[0, 0]) / half
        angles = np.asarray(tilts) + rng.uniform(-0.06, 0.06, 2)
        return placed(self._board, lens, *seen, rng.uniform(*distance), *angles, rng.uniform(0.0, turned))


def _ways(words: str) -> tuple[int, int]:
    """To the right and down, each -1, 0 or 1."""
    return ("right" in words) - ("left" in words), ("lower" in words) - ("upper" in words)
