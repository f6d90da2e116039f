"""Marker families: which cells of each print are white.

A family has a name: one of OpenCV's predefined dictionaries (DICT_4X4_50 ...), or a file <name>.yaml (or .yml) in one
of the folders that the environment variable SEATER_MARKER_FAMILIES lists, separated by colons (config/marker_families,
whose README.md describes the file). seater_perception::MarkerFamily reads the same names and files.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from seater_common.params import ParameterError, load, param, read_yaml

Image = NDArray[np.uint8]
FOLDERS = "SEATER_MARKER_FAMILIES"


@dataclass(frozen=True)
class FamilyFile:
    """What a family file holds."""

    bits: int = param(4, "", "bits along a side", low=3, high=8)
    border: int = param(1, "cells", "width of the black border", low=1, high=4)
    correctable_bits: int = param(0, "", "wrong bits that are mended", low=0, high=64)
    codes: list[str] = field(default_factory=list)  # one for each id: bits row by row from the top, 1 white

    def __post_init__(self) -> None:
        if not self.codes:
            raise ValueError("codes: is empty, must have at least one code")
        for i, code in enumerate(self.codes):
            bits = code.replace(" ", "")
            if set(bits) - {"0", "1"} or len(bits) != self.bits**2:
                raise ValueError(f"codes[{i}]: is {code!r}, must be a text of {self.bits**2} bits, 0 or 1")


@dataclass(frozen=True, eq=False)
class MarkerFamily:
    """A family of square markers."""

    name: str
    codes: Image  # (count, bits, bits): for each id, rows from the top as the print is read; 1 white, 0 black
    border: int = 1  # [cells] width of the black border
    correctable_bits: int = 0  # of a code

    def __len__(self) -> int:
        return len(self.codes)

    @property
    def bits(self) -> int:
        """Along a side of the code."""
        return int(self.codes.shape[1])

    @property
    def cells(self) -> int:
        """Along a side of the black square: bits and both borders."""
        return self.bits + 2 * self.border

    def print_of(self, marker_id: int) -> Image:
        """(cells, cells): the marker with its border, row 0 on top as it is read; 1 white, 0 black.

        Raises:
            ValueError: the family has no such id.
        """
        if not 0 <= marker_id < len(self):
            raise ValueError(f"markers: id {marker_id} is not in {self.name} (0..{len(self) - 1})")
        return np.pad(self.codes[marker_id], self.border)

    def image(self, marker_id: int, side: int) -> Image:
        """The same as an image, (side, side) px, 0 and 255. Raises ValueError."""
        white = 255 * self.print_of(marker_id)
        return np.asarray(cv2.resize(white, (side, side), interpolation=cv2.INTER_NEAREST), dtype=np.uint8)

    def dictionary(self) -> cv2.aruco.Dictionary:
        """As OpenCV's detector takes it; the border's width is one of the detector's own parameters."""
        dictionary = cv2.aruco.custom_dictionary(0, self.bits)
        dictionary.bytesList = np.concatenate([cv2.aruco.Dictionary_getByteListFromBits(code) for code in self.codes])
        dictionary.maxCorrectionBits = self.correctable_bits
        return dictionary


@lru_cache(maxsize=16)
def predefined(name: str) -> MarkerFamily:
    """One of OpenCV's dictionaries, by a name of `predefined_names`."""
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    size = dictionary.markerSize
    bits = [cv2.aruco.Dictionary_getBitsFromByteList(row[None], size) for row in dictionary.bytesList]
    return MarkerFamily(name, np.asarray(bits, dtype=np.uint8), 1, dictionary.maxCorrectionBits)


def predefined_names() -> list[str]:
    """The names of OpenCV's dictionaries."""
    names = [name for name in dir(cv2.aruco) if name.startswith("DICT_")]
    return [name for name in names if not re.search(r"\dH\d", name)]  # 16H5 stands there beside 16h5


def family_files() -> list[Path]:
    """All family files in the order of the folders, by name within each."""
    folders = [Path(folder) for folder in os.environ.get(FOLDERS, "").split(":") if folder]
    return [path for folder in folders for path in sorted([*folder.glob("*.yaml"), *folder.glob("*.yml")])]


def load_family(path: str | Path) -> MarkerFamily:
    """The family of a file; its name is the file's.

    Raises:
        ParameterError: naming the file and every key that is missing, unknown or wrong.
    """
    values = read_yaml(path)
    if isinstance(values, dict) and "nmarkers" in values:
        values = _of_opencv(values, path)
    read = load(FamilyFile, values, str(path))
    codes = [[int(bit) for bit in code.replace(" ", "")] for code in read.codes]
    shape = (len(codes), read.bits, read.bits)
    return MarkerFamily(Path(path).stem, np.array(codes, np.uint8).reshape(shape), read.border, read.correctable_bits)


def _of_opencv(values: dict[str, Any], path: str | Path) -> dict[str, Any]:
    """From the keys that cv::aruco::Dictionary::writeDictionary writes to those of FamilyFile."""
    try:
        codes = [values[f"marker_{i}"] for i in range(values["nmarkers"])]
        return {
            "bits": values["markersize"],
            "correctable_bits": values["maxCorrectionBits"],
            "border": 1,
            "codes": codes,
        }
    except (KeyError, TypeError) as error:
        raise ParameterError(f"{path}: is no dictionary of OpenCV: {error} is missing or wrong") from None


def marker_family(name: str) -> MarkerFamily:
    """The family of this name, or of the file at this path, which ends in .yaml or .yml.

    Raises:
        ParameterError: the name is not known, or its file is wrong.
    """
    names = (name, f"DICT_{name}")  # people leave it out
    for known in predefined_names():
        if known in names:
            return predefined(known)
    for path in family_files():
        if path.stem in names:
            return load_family(path)
    if Path(name).suffix in (".yaml", ".yml"):
        return load_family(name)
    known = ", ".join(predefined_names() + [path.stem for path in family_files()])
    raise ParameterError(f"dictionary: is {name!r}, must be one of {known} (files of {FOLDERS})")
