"""A printer and a camera for the tests: pages as pixels, and what the project's detector reads on them."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from numpy.typing import NDArray

import seater_perception as sp
from seater_common.geometry import Dock, Marker
from seater_common.marker_family import marker_family
from seater_common.params import load, read_yaml
from seater_tools.sheets.document import Document, make_document
from seater_tools.sheets.layout.paper import PAPERS

Image = NDArray[np.uint8]

ROOT = Path(__file__).resolve().parents[3]
CONFIG = ROOT / "config"
DEFAULT_DOCK = CONFIG / "docks" / "default.yaml"
DPI = 300
PIXEL = 25.4 / DPI  # [mm]


@dataclass(frozen=True)
class Seen:
    """What the detector reads: `corners` (4, 2) [px], from the top left one clockwise as the print is read."""

    id: int
    corners: NDArray[np.float64]

    @property
    def sides(self) -> NDArray[np.float64]:
        """Lengths of the four sides on the paper [mm]."""
        return np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1) * PIXEL

    @property
    def centre(self) -> NDArray[np.float64]:
        return np.asarray(self.corners.mean(axis=0))


def dock_of(path: Path) -> Dock:
    return load(Dock, read_yaml(path), path.name)


def dock_with(*markers: Marker, dictionary: str = "DICT_4X4_50") -> Dock:
    """The default dock with other markers."""
    return replace(Dock(), markers=list(markers), dictionary=dictionary)


def document_of(dock: Dock, paper: str = "a4") -> Document:
    return make_document(dock, marker_family(dock.dictionary), PAPERS[paper], "dock.yaml")


def pages_of(document: Document, first: int, last: int) -> list[Image]:
    """Pages first to last, from 1, as grey levels at DPI."""
    with TemporaryDirectory() as folder:
        pdf = Path(folder) / "sheets.pdf"
        pdf.write_bytes(document.pdf)
        words = ["pdftoppm", "-r", str(DPI), "-gray", "-f", str(first), "-l", str(last), str(pdf), f"{folder}/page"]
        subprocess.run(words, check=True)
        return [np.asarray(cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)) for path in sorted(Path(folder).glob("*.pgm"))]


def marker_pages(document: Document, index: int) -> list[Image]:
    """The pages of a marker of the document."""
    first = document.plan_pages + 1 + sum(len(entry.sheets) for entry in document.markers[:index])
    return pages_of(document, first, first + len(document.markers[index].sheets) - 1)


def read(image: Image, dock: Dock, shrink: int = 1) -> list[Seen]:
    """By the detector as the nodelet runs it, with its defaults: a camera that looks straight at the page.

    `shrink`: the camera's pixels are so many of the image's; corners are in pixels of the image.
    """
    if shrink > 1:
        image = np.asarray(cv2.resize(image, None, fx=1.0 / shrink, fy=1.0 / shrink, interpolation=cv2.INTER_AREA))
    height, width = image.shape
    K = (float(width), 0.0, 0.5 * (width - 1), 0.0, float(width), 0.5 * (height - 1), 0.0, 0.0, 1.0)
    camera = sp.CameraModel.raw(sp.Calibration(width, height, K, [0.0] * 5))
    layout = sp.layout_of_equal_markers(dock.dictionary, dock.markers[0].size)
    found = sp.DockDetector(camera, layout, sp.default_parameters()).detect(image).markers
    return [Seen(marker.id, (np.asarray(marker.corners) + 0.5) * shrink - 0.5) for marker in found]
