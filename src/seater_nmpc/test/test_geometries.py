"""The quick ones of the table of chairs, docks and cameras; geometries_evaluation.py docks with all of them."""

import pytest
from geometries import CASES, QUICK, Case, dock_once, failure

from seater_common.params import ParameterError


@pytest.mark.parametrize("case", [case for case in CASES if case.name in QUICK], ids=lambda case: case.name)
def test_docks_without_a_touch(case: Case) -> None:
    assert failure(*dock_once(case, case.starts[0])) == ""


@pytest.mark.parametrize("case", [case for case in CASES if case.refused], ids=lambda case: case.name)
def test_is_refused_before_anything_moves(case: Case) -> None:
    with pytest.raises(ParameterError) as caught:
        dock_once(case, case.starts[0])
    for words in case.refused:
        assert words in str(caught.value)


def test_the_table_is_large_enough_and_names_are_different() -> None:
    assert len(CASES) >= 24 and len({case.name for case in CASES}) == len(CASES)
    assert set(QUICK) < {case.name for case in CASES}
