"""The history of dockings: its file, its tests for change, what it says."""

from __future__ import annotations

import dataclasses
import datetime
import math
from pathlib import Path

import numpy as np
import pytest
from as_typed import run

from seater_tools.history import store
from seater_tools.history.collect import Collector, Result
from seater_tools.history.docking import COLUMNS, Docking, HistoryError, as_line
from seater_tools.history.drift import find_drift, normal_score
from seater_tools.history.evidence import added_up
from seater_tools.history.rate import find_rise
from seater_tools.history.report import panels
from seater_tools.history.store import append, read
from seater_tools.history.trends import SERIES, Notice, of_dock, warnings_of

BEGIN = datetime.datetime(2026, 5, 4, 8, 0, tzinfo=datetime.UTC)
TAUGHT = "# Taught: 2026-04-24T08:00:00Z, 60 measurements in 2.0 s, spread 0.10 mm 0.10 mm 0.010 deg\nname: hall\n"


def docking(number: int = 0, **changes: object) -> Docking:
    values = {"time": BEGIN + datetime.timedelta(hours=number), "dock": "hall", "code": 0, "text": "docked"}
    values |= {"duration": 12.5, "tries": 1, "reversals": 0, "contact": 1, "x": 0.001, "y": -0.002, "heading": 0.003}
    return Docking(**(values | changes))


def dockings(count: int, seed: int = 1, **shifts: tuple[int, float]) -> list[Docking]:
    """With noise; a shift: of a column, from this docking on, by so many of its standard deviations."""
    rng = np.random.default_rng(seed)
    spread = {"x": 0.002, "y": 0.002, "heading": 0.003, "duration": 1.0, "nis": 0.4}
    rows = []
    for n in range(count):
        values = {}
        for name, sd in spread.items():
            since, by = shifts.get(name, (count, 0.0))
            values[name] = sd * (rng.standard_normal() + (by if n >= since else 0.0))
        rows.append(docking(n, tries=1 + int(rng.random() < 0.04), **values))
    return rows


def test_a_line_is_read_as_it_was_written(tmp_path: Path) -> None:
    rows = [docking(0), docking(1, text='stands "beside", the\ndock', code=910, contact=0, x=math.nan, nis=3.25)]
    for row in rows:
        append(tmp_path / "h.csv", row)
    found, damaged = read(tmp_path / "h.csv")
    assert damaged == 0 and as_line(found[0]) == as_line(rows[0])
    assert found[1].text == 'stands "beside", the dock' and math.isnan(found[1].x) and found[1].nis == 3.25
    assert (tmp_path / "h.csv").read_text().splitlines()[0] == ",".join(COLUMNS)


def test_a_half_line_costs_only_itself(tmp_path: Path) -> None:
    path = tmp_path / "h.csv"
    append(path, docking(0))
    with path.open("a") as file:
        file.write("2026-05-04T09:00:00Z,hall,0,doc")  # the power was cut here
    append(path, docking(2))
    found, damaged = read(path)
    assert [d.time.hour for d in found] == [8, 10] and damaged == 1


def test_the_file_is_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(store, "MOST", 20)
    monkeypatch.setattr(store, "KEPT", 10)
    for n in range(25):
        append(tmp_path / "h.csv", docking(n))
    found, _ = read(tmp_path / "h.csv")
    assert len(found) == 14 and found[-1].time == docking(24).time and found[0].time == docking(11).time


def test_the_file_of_another_version_is_kept_beside(tmp_path: Path) -> None:
    (tmp_path / "h.csv").write_text("time,dock\n1,2\n")
    append(tmp_path / "h.csv", docking())
    assert len(read(tmp_path / "h.csv")[0]) == 1
    assert [p.read_text() for p in tmp_path.glob("h.csv.*")] == ["time,dock\n1,2\n"]


def test_no_history_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(HistoryError, match="cannot read"):
        read(tmp_path / "none.csv")
    (tmp_path / "other.csv").write_text("a,b\n")
    with pytest.raises(HistoryError, match="is no history"):
        read(tmp_path / "other.csv")


def test_a_docking_is_collected() -> None:
    collector = Collector()
    for v in (0.2, 0.0, 0.2, -0.1, -0.1, 0.1, 0.0):
        collector.asked(v)
    collector.innovation(3, False, math.nan, math.nan, math.nan)
    collector.innovation(0, True, 0.003, 0.004, 2.0)
    collector.innovation(4, False, 0.03, 0.04, 20.0)
    result = Result(0, "docked", 14.0, 1, False, (0.001, 0.002, 0.003), 0.002, 0.004)
    collector.contact(True)
    line = collector.finish(result, "hall", TAUGHT, BEGIN, {"mount_x": (0.01, 0.02)})
    assert (line.tries, line.reversals, line.images, line.contact) == (2, 2, 3, 1)
    assert line.accepted == pytest.approx(1 / 3) and line.nis == 11.0
    assert line.innovation == pytest.approx(math.sqrt((0.005**2 + 0.05**2) / 2))
    assert line.teaching_age == 10.0 and line.mount_x == 0.01 and line.mount_x_sd == 0.02 and math.isnan(line.depth)
    collector.begin()
    nothing = collector.finish(dataclasses.replace(result, position_sd=0.0), "hall", "", BEGIN, {})
    assert nothing.images == 0 and math.isnan(nothing.x) and nothing.taught == ""


def test_scores_of_what_does_not_change_are_standard_normal() -> None:
    """Whatever its distribution: here Cauchy's, which has no variance."""
    values = np.random.default_rng(1).standard_cauchy(1500)
    scores = np.array([normal_score(values[:n], values[n]) for n in range(20, len(values))])
    assert abs(scores.mean()) < 0.1 and scores.std() == pytest.approx(1.0, abs=0.06)
    assert abs(np.corrcoef(scores[1:], scores[:-1])[0, 1]) < 0.1


@pytest.mark.parametrize("shift", [2.0, -2.0])
def test_a_shift_is_found_where_it_began(shift: float) -> None:
    values = np.random.default_rng(2).standard_normal(100)
    values[60:] += shift
    drift = find_drift(values)
    assert drift is not None and abs(drift.begin - 60) <= 10 and 62 <= drift.noticed <= 80
    assert (drift.after - drift.before) * shift > 0.0
    with_gaps = np.insert(values, 30, [math.nan] * 5)
    assert find_drift(with_gaps).noticed == drift.noticed + 5


def test_false_warnings_are_rare_and_real_changes_are_found() -> None:
    """Of 60 series of 100 values without a change 0.1 are expected to warn (drift.py), of 20 of the other kind 0.2."""
    rng = np.random.default_rng(3)
    warned = sum(find_drift(rng.standard_normal(100)) is not None for _ in range(60))
    risen = sum(find_rise(rng.random(100) < 0.05) is not None for _ in range(20))
    assert warned <= 1 and risen <= 1
    rise = find_rise(np.append(rng.random(60) < 0.05, rng.random(25) < 0.7))
    assert rise is not None and rise.now > 3 * rise.before


def test_many_dockings_say_what_one_cannot() -> None:
    """60 mm that each docking knows to 20 mm only."""
    rng = np.random.default_rng(4)
    off = [docking(n, mount_y=0.06 + 0.02 * rng.standard_normal(), mount_y_sd=0.02) for n in range(12)]
    (found,) = added_up(off)
    assert found.is_off and found.count == 12 and abs(found.value - 0.06) < 3 * found.sd
    assert not added_up(off[:1])
    assert not any(e.is_off for e in added_up([dataclasses.replace(d, mount_y=0.01) for d in off]))
    assert any("camera's y" in notice.text and "calibrate mount" in notice.remedy for notice in warnings_of(off))


def test_a_camera_that_was_knocked_in_simulation_is_noticed() -> None:
    """Dockings out of rendered images in lock-step, seeds 0 to 31; from the 25th on the camera sits 60 mm ahead, and
    the chair ends 60 mm from the docked pose, called SUCCESS."""
    dockings, damaged = read(Path(__file__).with_name("simulated_history.csv"))
    assert len(dockings) == 32 and damaged == 0 and all(d.success for d in dockings)
    assert warnings_of(dockings[:24]) == []
    (notice,) = (n for n in warnings_of(dockings) if "distances" in n.text)
    assert notice.at is not None and 22 <= notice.at <= 26 and "doctor --move" in notice.remedy
    drawn, usual = ([one.name for one in panels(shown)] for shown in ([notice], []))
    assert set(drawn) - set(usual) == {"depth"}


def test_a_warning_of_the_nis_is_none_of_the_innovation() -> None:
    notice = Notice("innovation against its own uncertainty (NIS): 1 before, 9 since", "look")
    assert [one.name for one in SERIES if notice.is_of(one)] == ["nis"]


def test_only_dockings_of_one_dock_and_one_teaching_count() -> None:
    rows = [docking(0, dock="other"), docking(1, taught="a"), docking(2, taught="b"), docking(3, taught="b")]
    assert [d.time.hour for d in of_dock(rows, None)] == [10, 11]
    assert [d.dock for d in of_dock(rows, "other")] == ["other"] and of_dock(rows, "none") == []


def test_as_typed(tmp_path: Path) -> None:
    path, picture = tmp_path / "h.csv", tmp_path / "h.png"
    for row in dockings(60):
        append(path, row)
    done = run("history", "--file", path, "--picture", picture, "--last", "3")
    assert done.returncode == 0 and "no drift" in done.stdout and picture.stat().st_size > 10_000
    drifted = tmp_path / "d.csv"
    for row in dockings(80, y=(60, 3.0)):
        append(drifted, row)
    done = run("history", "--file", drifted, "--picture", picture)
    assert done.returncode == 1 and "final error across" in done.stdout and "seater teach" in done.stdout
    crosses = [line for line in done.stdout.splitlines() if line.startswith("\u2718")]
    assert len(crosses) == 1
    assert run("history", "--file", path, "--dock", "nowhere").returncode == 2
    assert run("history", "--file", tmp_path / "none.csv").returncode == 2
