"""Images of printed markers, made independently of the model inside the estimator.

Every pixel is divided into samples x samples; each sample asks the exact homography which cell of the print it sees (an
edge within a sample counts by its covered fraction). The PSF of the lens (and the path of a motion) is applied on that
fine grid, then the mean over each pixel's area is taken. A pixel's centre has integer coordinates: pixel u covers u -
1/2 .. u + 1/2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from seater_common.marker_family import marker_family
from seater_eval.perception.images.degraded_camera import DegradedCamera

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
Box = tuple[int, int, int, int]  # x0, y0, x1, y1 [px]; x1 and y1 are outside

_BLOCK = 32_000  # samples that are drawn at once: their arrays stay in the cache


@dataclass(frozen=True)
class Print:
    """A printed marker and its pose T_optical_marker (4, 4)."""

    dictionary: str
    id: int
    size: float  # [m] side of the black square
    pose: Array


@lru_cache(maxsize=256)
def marker_cells(dictionary: str, marker_id: int) -> NDArray[np.float32]:
    """(n, n), row 0 on top as the print is read: 1 white, 0 black; the black border is part of it."""
    return np.asarray(marker_family(dictionary).print_of(marker_id), dtype=np.float32)


def corners_of(print_: Print, K: Array, scale: float = 1.0) -> Array:
    """(4, 2) [px] corners of the black square, top left first, clockwise as the print is read; `scale` widens it."""
    h = 0.5 * print_.size * scale
    points = np.array([[-h, h, 0.0], [h, h, 0.0], [h, -h, 0.0], [-h, -h, 0.0]])
    seen = (points @ print_.pose[:3, :3].T + print_.pose[:3, 3]) @ K.T
    return np.asarray(seen[:, :2] / seen[:, 2:])


def box_of(print_: Print, camera: DegradedCamera, cells_around: float, pixels_around: float) -> Box:
    """The pixels that the sheet can touch, cut at the image's border (may be empty)."""
    n = len(marker_cells(print_.dictionary, print_.id))
    corners = corners_of(print_, camera.K, 1.0 + 2.0 * cells_around / n)
    low, high = corners.min(axis=0) - pixels_around, corners.max(axis=0) + pixels_around + 1.0
    x0, y0 = max(0, math.floor(low[0])), max(0, math.floor(low[1]))
    return (x0, y0, min(camera.image_width, math.ceil(high[0])), min(camera.image_height, math.ceil(high[1])))


def samples_for(print_: Print, camera: DegradedCamera) -> int:
    """Samples across a pixel. Too few displace edges: with 5 the estimate of a print of 183 px would be off by 1.5
    standard deviations of what noise does to it, with 12 by half of one."""
    side = camera.focal_length * print_.size / max(float(print_.pose[2, 3]), 1e-6)
    return 12 if side < 300.0 else 4 if side < 600.0 else 2


def reflectance(
    print_: Print,
    K: Array,
    box: Box,
    samples: int,
    paper: float,
    wall: float,
    border: int = 0,
    shift: tuple[float, float] = (0.0, 0.0),
) -> NDArray[np.float32]:
    """The sharp sheet on the fine grid of a box: 0 ink, 1 paper, `wall` outside of `paper` cells of quiet zone.
    `shift`: the grid lies so far [px] right of and below the pixels."""
    cells = marker_cells(print_.dictionary, print_.id)
    n = len(cells)
    # Round the cells a ring of paper, then one of wall; borders between them at -paper, 0, 1 .. n, n + paper.
    table = np.full((n + 4, n + 4), wall, np.float32)
    table[1:-1, 1:-1] = 1.0
    table[2:-2, 2:-2] = cells
    H = _pixel_to_cells(print_, K, n)
    x0, y0, x1, y1 = box
    u = shift[0] + x0 - border - 0.5 + (np.arange((x1 - x0 + 2 * border) * samples) + 0.5) / samples
    v = shift[1] + y0 - border - 0.5 + (np.arange((y1 - y0 + 2 * border) * samples) + 0.5) / samples
    wx, wy = _sample_width(H, 0.5 * (x0 + x1), 0.5 * (y0 + y1), samples)
    fine = np.empty((len(v), len(u)), np.float32)
    step = max(1, _BLOCK // max(1, len(u)))
    for start in range(0, len(v), step):
        rows = v[start : start + step, None]
        x, y, w = (H[i, 0] * u[None, :] + (H[i, 1] * rows + H[i, 2]) for i in range(3))
        x /= w
        y /= w
        fine[start : start + step] = _cover(table, n, paper, x, y, wx, wy)
    return fine


def _cover(
    table: NDArray[np.float32], n: int, paper: float, x: Array, y: Array, wx: float, wy: float
) -> NDArray[np.float32]:
    """Mean of the table over wx x wy cells round (x, y): the nearest border in each direction divides it. Overwrites x
    and y."""
    at, bx = _border(x, n, paper, wx)
    row, by = _border(y, n, paper, wy)
    row *= n + 4
    at += row
    flat, ax = table.ravel(), 1.0 - bx
    above, below = (flat[i:].take(at) * ax + flat[i + 1 :].take(at) * bx for i in (0, n + 4))
    return np.asarray(above * (1.0 - by) + below * by, dtype=np.float32)


def _border(x: Array, n: int, paper: float, width: float) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Number (in the table) of the cell before the nearest border, and the fraction that lies behind the border.
    Overwrites x."""
    nearest = np.rint(x)
    _limit(nearest, 0.0, float(n))
    number = nearest.astype(np.intp)
    number += 1
    low, high = x < -0.5 * paper, x > n + 0.5 * paper  # nearer to the sheet's edge than to the print's
    for beyond, edge, cell in ((low, -paper, 0), (high, n + paper, n + 2)):
        if beyond.any():
            nearest[beyond], number[beyond] = edge, cell
    x -= nearest
    x /= width
    x += 0.5
    _limit(x, 0.0, 1.0)
    return number, x.astype(np.float32)


def _limit(values: NDArray[np.floating[Any]], low: float, high: float) -> None:
    """np.clip in place, without what it costs beside."""
    np.maximum(values, low, out=values)
    np.minimum(values, high, out=values)


def _pixel_to_cells(print_: Print, K: Array, n: int) -> Array:
    """Homography: pixel -> (column, row) in cells from the print's top left corner, row downwards."""
    R, t = print_.pose[:3, :3], print_.pose[:3, 3]
    cell = print_.size / n
    # (column, row) -> marker frame: x = (column - n/2) cell, y = (n/2 - row) cell
    to_marker = np.array([[cell, 0.0, -0.5 * print_.size], [0.0, -cell, 0.5 * print_.size], [0.0, 0.0, 1.0]])
    return np.asarray(np.linalg.inv(K @ np.column_stack([R[:, 0], R[:, 1], t]) @ to_marker))


def _sample_width(H: Array, u: float, v: float, samples: int) -> tuple[float, float]:
    """How many cells one sample spans, across and down, in the middle of the print."""
    p = H @ np.array([u, v, 1.0])
    J = (H[:2, :2] * p[2] - np.outer(p[:2], H[2, :2])) / p[2] ** 2
    return float(np.abs(J[0]).max()) / samples, float(np.abs(J[1]).max()) / samples


def white_fraction(
    print_: Print,
    camera: DegradedCamera,
    box: Box,
    *,
    samples: int | None = None,
    motion: ArrayLike = (0.0, 0.0),
    endless_paper: bool = False,
    shift: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """The exposed box (height, width): 0 ink, 1 paper; with PSF and motion blur, without noise.

    Args:
        motion: path of the image during the exposure [px].
        endless_paper: no wall: the sheet never ends (what the estimator assumes).
        shift: of the pixels [px].
    """
    S = samples or samples_for(print_, camera)
    path: Array = np.asarray(motion, dtype=np.float64)
    border = math.ceil(4.0 * camera.blur_sd + 0.5 * float(np.linalg.norm(path))) + 1
    black, white, wall = camera.levels
    outside = 1.0 if endless_paper else (wall - black) / (white - black)
    paper = 1e3 if endless_paper else camera.quiet_zone
    fine = reflectance(print_, camera.K, box, S, paper, outside, border, shift)
    if np.any(path):
        fine = cv2.filter2D(fine, -1, _line_kernel(np.multiply(path, float(S))), borderType=cv2.BORDER_REPLICATE)
    across, down = (_psf_and_area(n, camera.blur_sd, S) for n in (fine.shape[1] // S, fine.shape[0] // S))
    mean = np.asarray(((down @ fine) @ across.T), dtype=np.float64)
    return mean[border:-border, border:-border]


@lru_cache(maxsize=64)
def _psf_and_area(pixels: int, psf_sd: float, samples: int) -> csr_array:
    """(pixels, pixels * samples): a Gaussian PSF on the grid of samples and the mean over each pixel in one, along one
    direction; the grid's border continues outside."""
    kernel = np.ones(1)
    if psf_sd > 0.0:
        reach = math.ceil(5.0 * psf_sd * samples)
        kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (psf_sd * samples)) ** 2)
    kernel = np.convolve(kernel / kernel.sum(), np.full(samples, 1.0 / samples))
    reach = (len(kernel) - samples) // 2
    rows = np.repeat(np.arange(pixels), len(kernel))
    columns = (np.arange(pixels)[:, None] * samples - reach + np.arange(len(kernel))[None, :]).ravel()
    columns = np.clip(columns, 0, pixels * samples - 1)
    weights = np.tile(kernel, pixels).astype(np.float32)
    return csr_array((weights, (rows, columns)), shape=(pixels, pixels * samples))


def _line_kernel(path: Array) -> NDArray[np.float32]:
    """A line of this length and direction [samples], its mass spread bilinearly, centred."""
    half = math.ceil(0.5 * float(np.abs(path).max())) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float64)
    steps = 8 * half + 1
    for t in (np.arange(steps) + 0.5) / steps - 0.5:
        x, y = half + t * path[0], half + t * path[1]
        i, j = math.floor(y), math.floor(x)
        a, b = y - i, x - j
        kernel[i : i + 2, j : j + 2] += np.outer([1.0 - a, a], [1.0 - b, b])
    return np.asarray(kernel / kernel.sum(), dtype=np.float32)


def clean_image(prints: list[Print], camera: DegradedCamera, motion: ArrayLike = (0.0, 0.0)) -> NDArray[np.float32]:
    """The whole image (height, width) [grey levels] without noise: wall, and on it the sheets."""
    image = np.full((camera.image_height, camera.image_width), camera.wall, np.float32)
    for print_ in prints:
        box = box_of(print_, camera, camera.quiet_zone, 4.0 * camera.blur_sd + 1.0)
        if box[0] >= box[2] or box[1] >= box[3]:
            continue
        black, white, _ = camera.levels
        white_part = white_fraction(print_, camera, box, motion=motion)
        image[box[1] : box[3], box[0] : box[2]] = black + (white - black) * white_part
    return image


def exposed(clean: NDArray[np.float32], noise_sd: float, random: np.random.Generator) -> Image:
    """With Gaussian noise, rounded and clipped to 8 bits."""
    grey = random.standard_normal(clean.shape, dtype=np.float32)
    grey *= noise_sd
    grey += clean
    np.rint(grey, out=grey)
    _limit(grey, 0.0, 255.0)
    return grey.astype(np.uint8)


def moved(print_: Print, change: ArrayLike) -> Print:
    """t' = t + d, R' = exp([w]x) R; change = (d, w), (6,) [m, rad]."""
    d = np.asarray(change, float)
    pose = print_.pose.copy()
    pose[:3, :3] = cv2.Rodrigues(d[3:])[0] @ pose[:3, :3]
    pose[:3, 3] += d[:3]
    return replace(print_, pose=pose)
