"""fault_table: what counts as wrong, what the watch measures, and wrong arguments."""

from types import SimpleNamespace
from typing import Any

import pytest

from seater_eval.faults import cases, command
from seater_eval.ros.fault_trial import NAMES, Watch

CASE = cases.Case("images end", ("fail", "camera", "off"), frozenset({"MARKER_LOST"}), rest=4.0)
GOOD: dict[str, Any] = {
    "result": "MARKER_LOST", "collisions": 0, "rest_s": 2.0, "moved_afterwards_m": 0.0, "again": "SUCCESS",
    "position_error_m": 1.0, "heading_error_deg": 5.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({"result": "TIMEOUT"}, "TIMEOUT instead of MARKER_LOST"),
        ({"collisions": 2}, "2 collisions"),
        ({"rest_s": 4.1}, "at rest after 4.1 s, limit 4.0 s"),
        ({"rest_s": float("inf")}, "at rest after inf s, limit 4.0 s"),
        ({"moved_afterwards_m": 0.02}, "moved by 0.020 m afterwards"),
        ({"again": "BUSY"}, "a new goal ended with BUSY"),
    ],
)
def test_what_is_wrong_with_an_end(changes: dict[str, Any], words: str) -> None:
    assert command.wrong(CASE, GOOD | changes) == words


def test_docked_beside_the_dock_is_never_right() -> None:
    case = cases.Case("twist zero", (), frozenset({"SUCCESS"}))
    docked = GOOD | {"result": "SUCCESS", "position_error_m": 0.005, "heading_error_deg": -0.5}
    assert command.wrong(case, docked) == ""
    for off in ({"position_error_m": 0.021}, {"heading_error_deg": -2.1}):
        assert command.wrong(case, docked | off) == "docked beside the dock"


def test_every_case_names_results_that_there_are_and_a_fault_that_there_is() -> None:
    from seater_sim.faults import kinds

    assert len({case.name for case in cases.CASES}) == len(cases.CASES)
    for case in cases.CASES:
        assert case.codes and case.codes <= set(NAMES.values())
        if case.action[0] == "fail":
            kinds.read(case.action[1], case.action[2], list(map(float, case.action[3:])))


def test_rest_and_way_of_a_chair_that_stops() -> None:
    """0.5 m/s for 2 s, then at rest; sampled every 20 ms."""
    rows = [(0.02 * k, min(0.01 * k, 1.0), 0.0, 0.0, 0.5 if k < 100 else 0.0, 0.0) for k in range(200)]
    watch: Any = SimpleNamespace(truth=rows)
    assert Watch.rest_after(watch, 1.0) == pytest.approx(0.98)
    assert Watch.way(watch, 1.0) == pytest.approx(0.5)
    assert Watch.rest_after(SimpleNamespace(truth=rows[:90]), 1.0) == float("inf")  # type: ignore[arg-type]
    assert Watch.rest_after(watch, 3.0) == 0.0


def test_no_such_fault(capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main("", ["--match", "meteorite"]) == 2
    assert "no fault's name contains 'meteorite'" in capsys.readouterr().err
