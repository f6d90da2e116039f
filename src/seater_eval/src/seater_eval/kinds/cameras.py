"""Kinds of cameras: what becomes of a scene between lens and file.

Optics blur and pixels average; cheap cameras leave lines out, denoise, sharpen, compress, over-expose, and some drivers
stretch contrasts. What no model of a camera has are smooth shifts of parts of the image by some tenths of a pixel:
prints that are not flat, what a calibration leaves of a lens, line jitter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_eval.perception.images.degraded_camera import DegradedCamera
from seater_eval.perception.images.render import Image, Print, clean_image

Grey = NDArray[np.float32]

OPTICS = DegradedCamera(640, 480, 600.0, 0.7, 0.0, black=45.0, white=205.0, wall=150.0, quiet_zone=2.0)
_FINER = 3  # times, of the image from which lines and columns are left out
_CORRELATION = (8.0, 20.0)  # [px] over which parts of an image are shifted much the same


@dataclass(frozen=True)
class Kind:
    """`blur`: sd of the optics' PSF [px]; None: one ray a pixel (lines left out, scaled to the nearest pixel)."""

    blur: float | None
    noise: float  # [grey levels] of the sensor
    file: Callable[[Grey], Image]  # from the sensor's values to 8 bits


def eight_bits(grey: Grey) -> Image:
    return np.asarray(np.clip(np.rint(grey), 0, 255), dtype=np.uint8)


def _blurred(grey: Grey, sd: float) -> Grey:
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), sd), dtype=np.float32)


def _sharpened(grey: Grey, amount: float, sd: float = 1.0) -> Grey:
    return np.asarray(grey + amount * (grey - _blurred(grey, sd)), dtype=np.float32)


def _jpeg(image: Image, quality: int) -> Image:
    return np.asarray(
        cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_GRAYSCALE)
    )


def _webcam(grey: Grey) -> Image:
    smooth = cv2.bilateralFilter(grey, 5, 20.0, 2.0)
    bright = 255.0 * np.clip(_sharpened(smooth, 0.8, 1.2) / 255.0, 0.0, 1.0) ** 0.8
    return _jpeg(eight_bits(np.asarray(bright, dtype=np.float32)), 75)


def _overexposed(grey: Grey) -> Image:
    """White is cut off, and light spills over."""
    return eight_bits(np.asarray(1.9 * grey + 0.12 * _blurred(grey, 12.0), dtype=np.float32))


def _binarised(grey: Grey) -> Image:
    return np.asarray(cv2.threshold(eight_bits(grey), 0, 255, cv2.THRESH_OTSU)[1], dtype=np.uint8)


KINDS = {
    "ideal": Kind(0.7, 2.0, eight_bits),
    "aliased": Kind(None, 1.0, eight_bits),
    "aliased, soft": Kind(None, 1.0, lambda grey: eight_bits(_blurred(grey, 0.35))),
    "sharpened": Kind(0.6, 2.0, lambda grey: _jpeg(eight_bits(_sharpened(grey, 1.0)), 85)),
    "sharpened twice": Kind(0.6, 1.5, lambda grey: _jpeg(eight_bits(_sharpened(grey, 2.0)), 85)),
    "webcam": Kind(0.8, 4.0, _webcam),
    "over-exposed": Kind(0.7, 1.0, _overexposed),
    "equalised": Kind(0.7, 2.0, lambda grey: np.asarray(cv2.equalizeHist(eight_bits(grey)), dtype=np.uint8)),
    "binarised": Kind(0.7, 2.0, _binarised),
}


def photograph(prints: list[Print], kind: str, shift: float, random: np.random.Generator) -> Image:
    """What a camera of this kind, OPTICS in front of it, delivers of these prints; parts of it shifted by `shift` px
    (standard deviation along each axis)."""
    return delivered(behind_lens(prints, KINDS[kind].blur), kind, shift, random)


def behind_lens(prints: list[Print], blur: float | None) -> Grey:
    """What all kinds of this `blur` have of these prints, before shifts and noise."""
    return _one_ray_a_pixel(prints) if blur is None else clean_image(prints, replace(OPTICS, blur_sd=blur))


def delivered(grey: Grey, kind: str, shift: float, random: np.random.Generator) -> Image:
    """`grey`: of behind_lens with the kind's blur."""
    made = KINDS[kind]
    if shift > 0.0:
        grey = _shifted(grey, shift, random)
    return made.file(grey + np.float32(made.noise) * random.standard_normal(grey.shape, dtype=np.float32))


def _one_ray_a_pixel(prints: list[Print]) -> Grey:
    fine = OPTICS.resized(_FINER * OPTICS.image_width, _FINER * OPTICS.image_height)
    return np.ascontiguousarray(clean_image(prints, replace(fine, blur_sd=0.0))[_FINER // 2 :: _FINER, 1::_FINER])


def _shifted(grey: Grey, sd: float, random: np.random.Generator) -> Grey:
    rows, columns = np.indices(grey.shape, dtype=np.float32)
    correlation = random.uniform(*_CORRELATION)
    fields = [_blurred(random.standard_normal(grey.shape, dtype=np.float32), correlation) for _ in range(2)]
    x, y = (np.float32(sd / float(field.std())) * field for field in fields)
    moved = cv2.remap(grey, columns + x, rows + y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, dtype=np.float32)
