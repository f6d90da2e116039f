"""Every chair, dock and camera of geometries.py docks from every start without a touch.

Each kind of geometry from one of its starts runs always, unless test_geometries.py drives just that; all geometries and
starts, which take minutes: `./seater test --all`. What is refused at start-up is in test_geometries.py.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from geometries import CASES, QUICK, Case, dock_once, failure, random_starts

RANDOM = ("D435", "D435 at 640 x 480", "Raspberry Pi camera 2", "bay 0.80 m", "open dock")
ALWAYS = ("open dock",)  # of those: the first random start
SELDOM = (  # another one of the same kind runs always, here or in test_geometries.py
    "bay 0.80 m",
    "deep bay",
    "short side walls",
    "open dock",
    "open dock, one marker, D435",
    "narrow chair",
    "front-wheel chair",
    "front-wheel chair, bay 0.80 m, D435",
    "D435",
    "markers off-centre",
    "D435 at 640 x 480",
    "Raspberry Pi camera 2",
    "Raspberry Pi camera 2, 1080p",
    "principal point off-centre",
    "camera aside",
    "camera high, looking down",
)


def driven() -> Iterator[Any]:
    """Cases with a start; what does not run always is marked as extensive."""
    for number, case in enumerate(case for case in CASES if not case.refused):
        often = {case.starts[number % len(case.starts)]}  # by turns the left and the right one
        often -= {case.starts[0]} if case.name in QUICK else set()
        often -= set(case.starts) if case.name in SELDOM else set()
        more = random_starts(case, 6) if case.name in RANDOM else []
        for start in [*case.starts, *more]:
            first = case.name in ALWAYS and start in more[:1]
            marks = () if start in often or first else pytest.mark.extensive
            yield pytest.param(case, start, id=f"{case.name} from {start}", marks=marks)


@pytest.mark.parametrize(("case", "start"), driven())
def test_docks_without_a_touch(case: Case, start: tuple[float, float, float]) -> None:
    assert failure(*dock_once(case, start)) == ""
