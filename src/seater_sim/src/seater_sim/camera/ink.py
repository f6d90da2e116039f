"""How much of each pixel the print of a marker covers: area sampling.

The image's patch is sampled S x S times per pixel. The texture has (nearly) one texel per sample, each texel is wholly
ink or paper, and bilinear interpolation turns every edge into a ramp of one sample's width that is symmetric about the
true edge. The sum of such ramps over the samples of a pixel is linear in the edge's place, so the covered area is right
without bias, even for edges that run exactly along the pixel rows, where point samples would jump by 1/S px.
"""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.camera_model import CameraModel
from seater_common.marker_family import marker_family
from seater_sim.camera.view import Frustum, bounding_box
from seater_sim.world.scene import Sheet

Array = NDArray[np.float64]
Image = NDArray[np.uint8]
Box = tuple[int, int, int, int]

MARGIN = 2  # [px] the ray map extends so far beyond the image
MAX_TEXELS = 512  # per cell


@lru_cache(maxsize=64)
def marker_cells(dictionary: str, marker_id: int) -> Image:
    """Ink of the marker's cells, (n, n): 255 black, 0 white; the black border is part of it.

    Raises:
        ValueError: the family `dictionary` is not known, or has no such id.
    """
    return np.asarray(255 * (1 - marker_family(dictionary).print_of(marker_id)), dtype=np.uint8)


@lru_cache(maxsize=64)
def texture(dictionary: str, marker_id: int, texels_x: int, texels_y: int) -> Image:
    """The cells, each as texels_y x texels_x equal texels."""
    cells = marker_cells(dictionary, marker_id)
    return np.ascontiguousarray(np.repeat(np.repeat(cells, texels_y, axis=0), texels_x, axis=1))


class InkRenderer:
    """Coverage of the pixels of one camera by the print of markers."""

    def __init__(self, frustum: Frustum, dictionary: str) -> None:
        self._frustum = frustum
        self._model: CameraModel = frustum.model
        self._dictionary = dictionary
        self._K_inverse = np.linalg.inv(self._model.K)
        self._rays = self._model.rays(MARGIN) if self._model.distorted else None

    def box(self, outline: Array) -> Box | None:
        """The pixels that the printed square, (4, 3) [m] in the optical frame, can touch; None: out of the image."""
        pixels = self._frustum.outline(outline)
        return None if pixels is None else bounding_box(pixels, self._model, 1.0)

    def coverage(self, sheet: Sheet, outline: Array, box: Box) -> Image:
        """Ink in each pixel of the box, (h, w), 0..255; `outline` as for `box`."""
        width, height = _sides(outline, self._model)
        cells = len(marker_cells(self._dictionary, sheet.marker.id))
        samples = _samples(max(width, height))
        texels_x, texels_y = _texels(width * samples / cells), _texels(height * samples / cells)
        print_ = texture(self._dictionary, sheet.marker.id, texels_x, texels_y)
        H = _ray_to_texel(outline, cells * texels_x, cells * texels_y)
        x0, y0, x1, y1 = box
        size = ((x1 - x0) * samples, (y1 - y0) * samples)
        if self._rays is None:
            # Sample i of the patch is at pixel x0 - 1/2 + (i + 1/2) / S.
            first = 0.5 / samples - 0.5
            to_pixel = np.array([[1.0 / samples, 0.0, x0 + first], [0.0, 1.0 / samples, y0 + first], [0.0, 0.0, 1.0]])
            flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
            fine = cv2.warpPerspective(print_, H @ self._K_inverse @ to_pixel, size, flags=flags)
        else:
            at = cv2.perspectiveTransform(self._fine_rays(box, samples), H)
            fine = cv2.remap(print_, at, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        if samples == 1:
            return np.asarray(fine, dtype=np.uint8)
        return np.asarray(cv2.resize(fine, (x1 - x0, y1 - y0), interpolation=cv2.INTER_AREA), dtype=np.uint8)

    def _fine_rays(self, box: Box, samples: int) -> NDArray[np.float32]:
        """Rays of the samples, interpolated between those of the pixels' centres."""
        assert self._rays is not None
        x0, y0, x1, y1 = box
        patch = self._rays[y0 + MARGIN - 1 : y1 + MARGIN + 1, x0 + MARGIN - 1 : x1 + MARGIN + 1]
        size = (patch.shape[1] * samples, patch.shape[0] * samples)
        fine = cv2.resize(patch, size, interpolation=cv2.INTER_LINEAR)
        return np.ascontiguousarray(fine[samples:-samples, samples:-samples])


def _sides(outline: Array, model: CameraModel) -> tuple[float, float]:
    """Width and height of the printed square in the image, roughly [px]."""
    focal = 0.5 * (model.K[0, 0] + model.K[1, 1])
    flat = outline[:, :2] / np.maximum(outline[:, 2:], 1e-3)
    lengths = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1) * focal
    return float(max(lengths[0], lengths[2])), float(max(lengths[1], lengths[3]))


def _samples(side: float) -> int:
    """Samples per pixel and axis: a small print needs many, a large one would only cost time."""
    return 4 if side < 40.0 else 2


def _texels(wanted: float) -> int:
    """Texels per cell, in steps of about a tenth so that few textures have to be kept."""
    exact = math.exp(round(math.log(max(wanted, 1.0)) * 10.0) / 10.0)
    return min(MAX_TEXELS, max(1, round(exact)))


def _ray_to_texel(outline: Array, width: int, height: int) -> Array:
    """3x3: a ray (x / z, y / z, 1) to the texture's coordinates (texel centres at integers), up to scale."""
    top_left, top_right, bottom_left = outline[0], outline[1], outline[3]
    to_plane = np.linalg.inv(np.column_stack([top_right - top_left, bottom_left - top_left, top_left]))
    to_texel = np.array([[width, 0.0, -0.5], [0.0, height, -0.5], [0.0, 0.0, 1.0]])
    return np.asarray(to_texel @ to_plane, dtype=float)
