"""From light to grey levels: PSF, vignetting, gain, noise."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_sim.settings import CameraSettings

Image = NDArray[np.uint8]

BANK = 1 << 21  # further values in the noise bank than one image needs


@lru_cache(maxsize=4)
def _noise_bank(sd: float, size: int) -> tuple[Image, Image]:
    """White noise in whole grey levels, split into what brightens and what darkens; the same for every run."""
    noise = np.rint(np.random.default_rng(20230917).standard_normal(size, dtype=np.float32) * sd)
    return np.clip(noise, 0, 255).astype(np.uint8), np.clip(-noise, 0, 255).astype(np.uint8)


class Sensor:
    """The effects of one camera. An image is (height, width) or (height, width, 3)."""

    def __init__(self, settings: CameraSettings, width: int, height: int) -> None:
        self._settings = settings
        self._shading = _vignette(settings.vignetting, width, height)
        self._kernel = 2 * max(1, round(3.0 * settings.blur_sd)) + 1

    def expose(self, light: Image, seed: int, index: int) -> Image:
        """The image number `index`; its noise depends on seed and index only."""
        image = self._shade(self._spread(light))
        if self._settings.noise_sd > 0.0:
            image = self._add_noise(image, seed, index)
        return image

    def _spread(self, light: Image) -> Image:
        sd = self._settings.blur_sd
        if sd <= 0.0:
            return light
        size = (self._kernel, self._kernel)
        return np.asarray(cv2.GaussianBlur(light, size, sd, borderType=cv2.BORDER_REPLICATE), dtype=np.uint8)

    def _shade(self, light: Image) -> Image:
        if self._settings.vignetting == 0.0 and self._settings.gain == 1.0:
            return light
        shading = self._shading if light.ndim == 2 else cv2.merge([self._shading] * 3)
        return np.asarray(cv2.multiply(light, shading, scale=self._settings.gain / 255.0), dtype=np.uint8)

    def _add_noise(self, image: Image, seed: int, index: int) -> Image:
        """A stretch of the bank from a random place, read forwards or backwards, upright or negative."""
        rng = np.random.default_rng([seed, 2, index])
        start, backwards, negative = int(rng.integers(BANK)), bool(rng.integers(2)), bool(rng.integers(2))
        brighter, darker = (bank[start : start + image.size] for bank in self._bank(image.size))
        if negative:
            brighter, darker = darker, brighter
        # One of the two is zero at every pixel, so the sums saturate rightly.
        flat = image.reshape(-1)[::-1] if backwards else image.reshape(-1)
        noisy = cv2.subtract(cv2.add(np.ascontiguousarray(flat), brighter), darker).reshape(-1)
        return np.ascontiguousarray(noisy[::-1] if backwards else noisy).reshape(image.shape)

    def _bank(self, size: int) -> tuple[Image, Image]:
        return _noise_bank(self._settings.noise_sd, BANK + size)


def _vignette(loss: float, width: int, height: int) -> Image:
    """Brightness of each pixel, 255: full; falls with the square of the distance from the middle."""
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    x, y = (x - 0.5 * (width - 1)) / (0.5 * (width - 1)), (y - 0.5 * (height - 1)) / (0.5 * (height - 1))
    r2 = (x**2 * width**2 + y**2 * height**2) / (width**2 + height**2)
    return np.rint(255.0 * (1.0 - loss * r2)).astype(np.uint8)
