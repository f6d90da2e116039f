"""What an image says of exposure and of markers that the dock's file does not have."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.marker_family import predefined_names

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

LIMIT = 254  # [grey levels] of 255: at the sensor's limit
MARGIN = 0.12  # of the side: of the white margin round the code that is looked at
SMALLEST = 24.0  # [px] side of a foreign marker: smaller squares are taken for markers of large families too easily


def white_of(image: Image, corners: Sequence[Array]) -> tuple[float, float] | None:
    """Share of the markers' white at the sensor's limit, and white less black [grey levels]; None without a marker.

    image: (height, width) grey; corners: (4, 2) [px] of each marker.
    """
    mask = np.zeros(image.shape, dtype=np.uint8)
    for square in corners:
        middle = square.mean(axis=0)
        grown = middle + (1.0 + 2.0 * MARGIN) * (square - middle)
        cv2.fillConvexPoly(mask, np.round(grown).astype(np.int32), 1)
    grey = image[mask > 0]
    if len(grey) == 0:
        return None
    dark, bright = np.percentile(grey, (5, 95))
    white = grey[grey > 0.5 * (float(dark) + float(bright))]
    return (float(np.mean(white >= LIMIT)) if len(white) else 0.0), float(bright) - float(dark)


def other_markers(image: Image, dictionary: str, ids: Sequence[int]) -> tuple[str, tuple[int, ...]] | None:
    """Family and ids of markers in an image that shows none of the dock's. The dock's own family comes first; of
    others two at least must be found, as large families find a code in many a square."""
    parameters = cv2.aruco.DetectorParameters_create()
    names = [name for name in predefined_names() if name != dictionary]
    for name in [dictionary, *names] if dictionary in predefined_names() else names:
        found = cv2.aruco.detectMarkers(
            image, cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name)), parameters=parameters
        )
        seen = [] if found[1] is None else found[1].ravel().tolist()
        large = [id for id, square in zip(seen, found[0], strict=True) if _side(square.reshape(4, 2)) >= SMALLEST]
        if name == dictionary and large:
            foreign = tuple(sorted(set(large) - set(ids)))
            return (name, foreign) if foreign else None
        if len(large) >= 2:
            return name, tuple(sorted(large))
    return None


def _side(square: Array) -> float:
    return float(np.mean(np.linalg.norm(square - np.roll(square, 1, axis=0), axis=1)))
