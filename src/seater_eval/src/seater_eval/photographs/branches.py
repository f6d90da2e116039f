"""Which of a marker's two poses is taken, and what the photometric stage does to those that corners have decided."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.perception.images.scenes import normal_error
from seater_eval.photographs.detectors import Found

WRONG_BRANCH = math.radians(15.0)
CERTAIN = 0.05  # ambiguity below which a detector has called its branch decided


@dataclass(frozen=True, kw_only=True)
class Branch:
    """Of the most probable pose of one marker."""

    right: bool  # its normal is that of the truth, to within WRONG_BRANCH
    certain: bool  # called decided

    @property
    def wrong_and_certain(self) -> bool:
        return self.certain and not self.right


def branch_of(found: Found, truth: NDArray[np.float64]) -> Branch:
    """`truth`: T_optical_marker (4, 4). `found` has to have a pose."""
    assert found.pose is not None
    return Branch(right=normal_error(found.pose, truth) <= WRONG_BRANCH, certain=found.ambiguity < CERTAIN)


def count_broken(by_corners: Mapping[Any, Branch], shipped: Mapping[Any, Branch]) -> dict[str, int]:
    """Of the markers (by any key) that both have:

    corners_decided: corners alone call their branch certain, and it is right
    broken: of these, `shipped` calls the other branch certain
    open: of these, `shipped` has the other branch first, and says that it is not decided
    corners_wrong: corners alone call their branch certain, and it is wrong
    mended: of these, `shipped` has the right one first
    """
    both = [key for key in by_corners if key in shipped]
    right, wrong = (
        [key for key in both if by_corners[key].certain and by_corners[key].right is it] for it in (True, False)
    )
    return {
        "corners_decided": len(right),
        "broken": sum(shipped[key].wrong_and_certain for key in right),
        "open": sum(not shipped[key].right and not shipped[key].certain for key in right),
        "corners_wrong": len(wrong),
        "mended": sum(shipped[key].right for key in wrong),
    }
