"""Every chair, dock and camera of geometries.py docks from every start without a touch.

It takes minutes: `./seater test --only evaluation`. What is refused at start-up is in test_geometries.py.
"""

import pytest
from geometries import CASES, Case, dock_once, failure, random_starts

RANDOM = ("D435", "D435 at 640 x 480", "Raspberry Pi camera 2", "bay 0.80 m", "open dock")
DRIVEN = [(case, start) for case in CASES if not case.refused for start in case.starts]
DRIVEN += [(case, start) for case in CASES if case.name in RANDOM for start in random_starts(case, 6)]


@pytest.mark.parametrize(("case", "start"), DRIVEN, ids=[f"{case.name} from {start}" for case, start in DRIVEN])
def test_docks_without_a_touch(case: Case, start: tuple[float, float, float]) -> None:
    assert failure(*dock_once(case, start)) == ""
