"""Every chair, dock and camera of geometries.py docks from every start without a touch.

Each geometry from one of its starts runs always, unless test_geometries.py drives just that; all starts, which take
minutes: `./seater test --all`. What is refused at start-up is in test_geometries.py.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from geometries import CASES, QUICK, Case, dock_once, failure, random_starts

RANDOM = ("D435", "D435 at 640 x 480", "Raspberry Pi camera 2", "bay 0.80 m", "open dock")
ALWAYS = 1  # of the random starts


def driven() -> Iterator[Any]:
    """Cases with a start; what does not run always is marked as extensive."""
    for number, case in enumerate(case for case in CASES if not case.refused):
        often = {case.starts[number % len(case.starts)]}  # by turns the left and the right one
        often -= {case.starts[0]} if case.name in QUICK else set()
        more = random_starts(case, 6) if case.name in RANDOM else []
        for start in [*case.starts, *more]:
            marks = () if start in often or start in more[:ALWAYS] else pytest.mark.extensive
            yield pytest.param(case, start, id=f"{case.name} from {start}", marks=marks)


@pytest.mark.parametrize(("case", "start"), driven())
def test_docks_without_a_touch(case: Case, start: tuple[float, float, float]) -> None:
    assert failure(*dock_once(case, start)) == ""
