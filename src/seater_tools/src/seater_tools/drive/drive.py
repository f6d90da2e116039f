"""The recorded drive and its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seater_common.params import why

Array = NDArray[np.float64]

FEWEST_IMAGES = 30  # with a marker, within the odometry's time
FEWEST_ODOMETRY = 50  # messages
_KEYS = ("odometry", "stamps", "image", "ids", "corners", "covariance")


class DriveError(ValueError):
    """The recording holds too little, or what it holds is no drive."""


@dataclass(frozen=True, eq=False)
class Drive:
    """Times are stamps of one clock [s]; one row of `image`, `ids`, `corners`, `covariance` for each marker seen.

    odometry: (m, 4) stamp, x, y [m], heading [rad] of base_link in odom
    stamps: (k,) of the images, sorted; at least one marker is seen in each
    image: (n,) index into `stamps`
    ids: (n,) of the marker
    corners: (n, 4, 2) [px] in the raw image: top-left, top-right, bottom-right, bottom-left as the print is read
    covariance: (n, 8, 8) [px^2] of the corners, x and y of each in this order

    Raises DriveError when there are too few of a kind, or they do not overlap in time.
    """

    odometry: Array
    stamps: Array
    image: NDArray[np.intp]
    ids: NDArray[np.intp]
    corners: Array
    covariance: Array

    def __post_init__(self) -> None:
        n = len(self.ids)
        shapes = (self.odometry.shape[1:], self.image.shape, self.corners.shape, self.covariance.shape)
        if shapes != ((4,), (n,), (n, 4, 2), (n, 8, 8)):
            raise DriveError(f"a drive's arrays have the wrong shapes: {shapes}")
        if not all(np.all(np.isfinite(getattr(self, key))) for key in _KEYS):
            raise DriveError("a drive holds numbers that are not finite")
        if len(self.odometry) < FEWEST_ODOMETRY:
            raise DriveError(f"odometry: {len(self.odometry)} messages, at least {FEWEST_ODOMETRY} are needed")
        begin, end = self.odometry[0, 0], self.odometry[-1, 0]
        inside = int(np.sum((self.stamps >= begin) & (self.stamps <= end)))
        if inside < FEWEST_IMAGES:
            raise DriveError(
                f"{inside} images that show a marker within the odometry's time, at least {FEWEST_IMAGES} are needed "
                f"({len(self.stamps)} images in all; are the stamps of one clock?)"
            )

    def chosen(self, images: NDArray[np.intp]) -> Drive:
        """Only these images (indices, ascending)."""
        rows = np.isin(self.image, images)
        image = np.searchsorted(images, self.image[rows])
        return Drive(
            self.odometry, self.stamps[images], image, self.ids[rows], self.corners[rows], self.covariance[rows]
        )

    def without(self, sightings: NDArray[np.bool_]) -> Drive:
        """These sightings of markers (n,) left out; all images stay."""
        kept = ~sightings
        return Drive(
            self.odometry, self.stamps, self.image[kept], self.ids[kept], self.corners[kept], self.covariance[kept]
        )

    def save(self, path: Path) -> None:
        """As a compressed .npz."""
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(path, **{key: getattr(self, key) for key in _KEYS})

    @staticmethod
    def load(path: Path) -> Drive:
        """Raises DriveError: no such file, or not one that `save` has written."""
        try:
            with np.load(path) as file:
                return Drive(**{key: file[key] for key in _KEYS})
        except (OSError, KeyError, ValueError) as error:
            if isinstance(error, DriveError):
                raise
            raise DriveError(f"cannot read {path}: {why(error)}") from error
