"""Which detectors there are beside Debian's OpenCV, and what they can be asked for."""

from __future__ import annotations

# name -> what it is; the packages are those of tools/requirements_peers.txt.
PEERS = {
    "locus": "locus-tag, profile standard",
    "locus_grid": "locus-tag, profile grid",
    "rapidtag": "rapidtag, sub-pixel corners",
    "opencv5": "opencv-contrib-python, sub-pixel corners",
    "opencv5_apriltag": "opencv-contrib-python, APRILTAG refinement",
    "apriltag": "pupil-apriltags, full resolution",
}
COLOURS = {
    "locus": "#b8860b",
    "locus_grid": "#e0b040",
    "rapidtag": "#d07aa8",
    "opencv5": "#8c564b",
    "opencv5_apriltag": "#c49c94",
    "apriltag": "#17becf",
}
_OF_LOCUS = frozenset(
    {"DICT_4X4_50", "DICT_4X4_100", "DICT_6X6_250", "DICT_APRILTAG_16h5", "DICT_APRILTAG_36h11", "DICT_ARUCO_MIP_36h12"}
)
_OF_APRILTAG = frozenset({"DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h11"})
_KNOWN = {"locus": _OF_LOCUS, "locus_grid": _OF_LOCUS, "apriltag": _OF_APRILTAG}


def knows(name: str, dictionary: str) -> bool:
    """Whether this peer finds markers of this dictionary; those without a list know all of OpenCV's."""
    return name not in _KNOWN or dictionary in _KNOWN[name]
