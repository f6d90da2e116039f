"""fault_table: what counts as wrong, what the watch measures, and wrong arguments."""

import json
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from seater_common.command.ending import INTERRUPTED
from seater_eval.faults import cases, command
from seater_eval.faults.row_file import NOT_RUN, RowFile
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


def test_rows_of_an_interrupted_run_are_not_lost(tmp_path: Path) -> None:
    """Only those of the same state count, and one that was cut off is measured again."""
    path = tmp_path / "rows.jsonl"
    rows = RowFile(path, "state 1")
    rows.add({"fault": "a", "place": "way", "result": "TIMEOUT"})
    rows.add({"fault": "a", "place": "bay", "result": NOT_RUN})
    rows.add({"fault": "b", "place": "way", "result": "BUSY"})
    path.write_text(path.read_text()[:-4])  # the power fails
    again = RowFile(path, "state 1")
    assert list(again.done) == [("a", "way")] and not again.dropped
    again.add({"fault": "c", "place": "way", "result": "BUSY"})
    again.close()
    other = RowFile(path, "state 2")
    assert not other.done and other.dropped == 2
    assert "TIMEOUT" in (tmp_path / "rows.old.jsonl").read_text()


def test_finished_rows_leave_those_of_another_run(tmp_path: Path) -> None:
    rows = RowFile(tmp_path / "rows.jsonl", "state")
    for fault in ("a", "b"):
        rows.add({"fault": fault, "place": "way", "result": "BUSY"})
    rows.finish([("a", "way")])
    assert list(RowFile(rows.path, "state").done) == [("b", "way")]
    rows.finish([("b", "way")])
    assert not rows.path.exists()


def test_an_interrupted_table_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tried: list[tuple[int, str]] = []

    def trial(number: int, place: str, folder: Path) -> dict[str, Any]:
        tried.append((number, place))
        if len(tried) == 2:
            raise KeyboardInterrupt
        return GOOD | {"fault": cases.CASES[number].name, "place": place, "text": "", "result": "EMERGENCY_STOP"}

    monkeypatch.setattr(command, "_trial", trial)
    arguments = ["--match", "emergency stop", "--results", str(tmp_path), "--config", str(tmp_path)]
    with pytest.raises(SystemExit) as ended:
        command.main("", arguments)
    assert ended.value.code == INTERRUPTED and "1 rows are in" in capsys.readouterr().out
    assert command.main("", arguments) == 1  # at rest after 2 s is too late
    assert [place for _, place in tried] == ["way", "bay", "bay"]
    assert "1 rows of an interrupted run count" in capsys.readouterr().out
    assert len(json.loads((tmp_path / "fault_table.json").read_text())["rows"]) == 2


def test_a_trial_that_is_interrupted_ends_what_it_has_launched() -> None:
    """Not killed at once: it needs time for that."""
    script = "import signal,sys,time;signal.signal(15,lambda *a:(time.sleep(0.3),sys.exit(7)));print(1,flush=True)"
    process = subprocess.Popen([sys.executable, "-c", f"{script};time.sleep(60)"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline()
    with pytest.raises(KeyboardInterrupt), command._ended_in_order(process):
        raise KeyboardInterrupt
    assert process.returncode == 7
