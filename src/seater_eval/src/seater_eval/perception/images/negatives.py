"""Images in which there is no marker of the dictionary looked for, but much that resembles one."""

from __future__ import annotations

import string

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.marker_family import marker_family

Image = NDArray[np.uint8]
KINDS = ("noise", "checkerboard", "text", "foliage", "other dictionaries")
OTHER_IDS = "same dictionary, other ids"  # nothing for who looks for the dock's ids alone
DICTIONARY, FIRST_OTHER = "DICT_4X4_50", 3  # the dock has 0, 1 and 2
# Not of these: 4X4_50 is looked for, and the larger 4X4 dictionaries begin with its markers.
OTHERS = (
    "DICT_5X5_50",
    "DICT_6X6_50",
    "DICT_7X7_50",
    "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_25h9",
    "DICT_APRILTAG_36h11",
)


def negative(kind: str, width: int, height: int, psf_sd: float, noise_sd: float, seed: int) -> Image:
    """One image (height, width) of a kind of KINDS or OTHER_IDS, through the same PSF and noise as the others."""
    random = np.random.default_rng(seed)
    canvas = _DRAW[kind](random, width, height).astype(np.float32)
    if kind != "noise" and psf_sd > 0.0:
        canvas = cv2.GaussianBlur(canvas, (0, 0), psf_sd)
    noisy = canvas + noise_sd * random.standard_normal(canvas.shape, dtype=np.float32)
    return np.asarray(np.clip(np.rint(noisy), 0, 255), dtype=np.uint8)


def _noise(random: np.random.Generator, width: int, height: int) -> Image:
    """White or correlated, weak or strong."""
    grain = random.uniform(0.0, 6.0)
    base = random.standard_normal((height, width), dtype=np.float32)
    if grain > 0.5:
        base = cv2.GaussianBlur(base, (0, 0), grain)
    base *= random.uniform(10.0, 90.0) / max(float(base.std()), 1e-6)
    return np.asarray(np.clip(128.0 + base, 0, 255), dtype=np.uint8)


def _checkerboard(random: np.random.Generator, width: int, height: int) -> Image:
    """A regular board seen obliquely, or squares that are black by chance: random codes without a border."""
    n = int(random.integers(6, 40))
    if random.random() < 0.5:
        board = (np.indices((n, n)).sum(axis=0) % 2).astype(np.uint8)
    else:
        board = random.integers(0, 2, (n, n), dtype=np.uint8)
    texture = cv2.resize(40 + 175 * board, (1200, 1200), interpolation=cv2.INTER_NEAREST)
    return _warped(random, texture, width, height)


def _text(random: np.random.Generator, width: int, height: int) -> Image:
    """Lines of letters in sizes from a line of print to a headline."""
    page = np.full((height, width), int(random.integers(180, 240)), np.uint8)
    letters = np.array(list(string.ascii_letters + string.digits + "#@%&[]{}|"))
    y = 10
    while y < height:
        scale = float(random.uniform(0.4, 3.0))
        y += int(32 * scale)
        line = "".join(random.choice(letters, 90))
        thick = max(1, round(2 * scale * float(random.uniform(0.5, 1.6))))
        cv2.putText(
            page, line, (int(random.integers(-40, 20)), y), cv2.FONT_HERSHEY_SIMPLEX, scale, 30, thick, cv2.LINE_AA
        )
    return page


def _foliage(random: np.random.Generator, width: int, height: int) -> Image:
    """Overlapping leaves: ellipses and four-sided patches of every size, light and dark."""
    page = np.full((height, width), 90, np.uint8)
    for _ in range(900):
        at = (int(random.integers(0, width)), int(random.integers(0, height)))
        grey, size = int(random.integers(20, 230)), float(random.uniform(4.0, 45.0))
        if random.random() < 0.6:
            axes = (max(1, int(size)), max(1, int(size * random.uniform(0.2, 0.7))))
            cv2.ellipse(page, at, axes, float(random.uniform(0, 180)), 0, 360, grey, -1, cv2.LINE_AA)
        else:
            angles = np.sort(random.uniform(0, 2 * np.pi, 4))
            points = np.array(at) + size * np.column_stack([np.cos(angles), np.sin(angles)])
            cv2.fillConvexPoly(page, points.astype(np.int32), grey, cv2.LINE_AA)
    return page


def _other_dictionaries(random: np.random.Generator, width: int, height: int) -> Image:
    """A dozen markers with other codes on white sheets."""
    page = np.full((height, width), 150, np.uint8)
    for _ in range(12):
        name = OTHERS[int(random.integers(len(OTHERS)))]
        drawn = marker_family(name).image(int(random.integers(0, 30)), 180)
        sheet = cv2.copyMakeBorder(np.where(drawn > 127, 215, 40).astype(np.uint8), 26, 26, 26, 26, 0, value=215)
        side = int(random.integers(24, 260))
        small = cv2.resize(sheet, (side, side), interpolation=cv2.INTER_AREA)
        small = np.rot90(small, int(random.integers(4)))
        x, y = int(random.integers(0, width - side)), int(random.integers(0, height - side))
        page[y : y + side, x : x + side] = small
    return page


def _other_ids(random: np.random.Generator, width: int, height: int) -> Image:
    """Two dozen small markers of the dictionary, with ids that the dock has not: at 12 px codes are much alike."""
    page = np.full((height, width), 150, np.uint8)
    family = marker_family(DICTIONARY)
    for _ in range(24):
        drawn = family.image(int(random.integers(FIRST_OTHER, 50)), 180)
        sheet = cv2.copyMakeBorder(np.where(drawn > 127, 215, 40).astype(np.uint8), 30, 30, 30, 30, 0, value=215)
        side = round(float(random.uniform(12.0, 26.0)) * 240 / 180)
        small = np.rot90(cv2.resize(sheet, (side, side), interpolation=cv2.INTER_AREA), int(random.integers(4)))
        x, y = int(random.integers(0, width - side)), int(random.integers(0, height - side))
        page[y : y + side, x : x + side] = small
    return page


def _warped(random: np.random.Generator, texture: Image, width: int, height: int) -> Image:
    n = texture.shape[0]
    source = np.array([[0, 0], [n, 0], [n, n], [0, n]], np.float32)
    target = source * (min(width, height) / n) * random.uniform(0.5, 1.2)
    target += random.uniform(-0.15, 0.15, (4, 2)) * height + np.array([random.uniform(0, 0.5) * width, 0.0])
    H = cv2.getPerspectiveTransform(source, target.astype(np.float32))
    return np.asarray(cv2.warpPerspective(texture, H, (width, height), flags=cv2.INTER_AREA, borderValue=150))


_DRAW = {
    "noise": _noise,
    "checkerboard": _checkerboard,
    "text": _text,
    "foliage": _foliage,
    "other dictionaries": _other_dictionaries,
    OTHER_IDS: _other_ids,
}
