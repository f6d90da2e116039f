"""What the tests make of an evaluation command's bars."""

from typing import Any

import pytest
from evaluation_bars import UNDECIDABLE, report

from seater_eval.report.bars import Bar


def bar(met: bool = True, name: str = "error", measured: bool = True) -> dict[str, Any]:
    """As the commands write it, with neither unit nor note."""
    return Bar(name, (0.5 if met else 1.5) if measured else None, 1.0).as_mapping()


def counts(code: int, *bars: dict[str, Any]) -> tuple[int, ...]:
    suite = report("range", code, list(bars))
    return tuple(int(suite.get(key, "-1")) for key in ("tests", "failures", "errors", "skipped"))


def test_every_bar_is_a_case_and_a_missed_one_fails() -> None:
    assert counts(0, bar(), bar()) == (2, 0, 0, 0)
    assert counts(1, bar(), bar(met=False)) == (2, 1, 0, 0)


def test_an_undecidable_bar_is_skipped_only_when_it_was_measured() -> None:
    (name,) = UNDECIDABLE
    assert counts(1, bar(met=False, name=name)) == (1, 0, 0, 1)
    assert counts(1, bar(met=False, name=name, measured=False)) == (1, 1, 0, 0)


@pytest.mark.parametrize(("code", "bars"), [(0, []), (1, []), (3, [bar()]), (0, [bar(met=False)])])
def test_a_command_that_contradicts_its_bars_is_an_error(code: int, bars: list[dict[str, Any]]) -> None:
    assert counts(code, *bars)[2] == 1
