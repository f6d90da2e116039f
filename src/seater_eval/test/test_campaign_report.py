"""Statistics against the literature, tables and the page; shards become one campaign only if they belong together."""

import csv
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from campaign_plans import CONFIG

from seater_common.params import ParameterError
from seater_eval.campaign.plan import Plan, Shard
from seater_eval.campaign.report.figures import worst
from seater_eval.campaign.report.page import write_page
from seater_eval.campaign.report.statistics import influences, wilson
from seater_eval.campaign.report.summary import campaign_bars, summarize
from seater_eval.campaign.report.table import flat, write_tables
from seater_eval.campaign.report.text import describe
from seater_eval.campaign.results import bars_of, campaign_data, file_name, merge
from seater_eval.report.bars import all_met, write_results

LIMITS = {
    "docked": 0.9,
    "touched": 0.0,
    "position_p95": 5.0,
    "heading_p95": 0.6,
    "reversals_p95": 1.0,
    "realtime_factor": 1.5,
}


def row(index: int, docked: bool = True, **more: Any) -> dict[str, Any]:
    """A run that went well, or did not."""
    made = {
        "index": index,
        "seed": 100 + index,
        "variants": {"dock": "wide" if index % 2 else "narrow"},
        "numbers": {"simulator/plant/lag_v": 0.01 * index, "simulator/camera/rate": float(index % 5)},
        "start": [-2.0, 0.01 * index, 0.0],
        "docked": docked,
        "touched": False,
        "at_rest": True,
        "result": "SUCCESS" if docked else "MARKER_LOST",
        "text": "docked" if docked else f"no marker seen for 0.{index} m and 1.2 s",
        "retries": 0,
        "position_error_m": 0.001 + 1e-5 * index,
        "heading_error_deg": -0.1,
        "lateral_error_m": -0.0005,
        "docking_time_s": 12.0,
        "min_clearance_m": 0.1,
        "reversals": 0.0,
        "simulated_s": 20.0,
        "core_s": 8.0,
        "core_render_s": 4.0,
        "path": [[-2.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    }
    return made | more


def crashed(index: int) -> dict[str, Any]:
    """A run of which nothing is known but that it crashed."""
    text = "Traceback <most recent call last>:\n  RuntimeError: the lens fell off"
    return {"index": index, "seed": 3, "docked": False, "touched": False, "at_rest": None} | {
        "result": "CRASHED",
        "text": text,
    }


ROWS = [*(row(i) for i in range(38)), row(38, docked=False), crashed(39)]


@pytest.mark.parametrize(
    ("successes", "runs", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_wilson_intervals_are_those_of_newcombe_1998(successes: int, runs: int, low: float, high: float) -> None:
    """Table I of Newcombe, Statistics in Medicine 17, 1998: method 3, score without continuity correction."""
    assert wilson(successes, runs) == pytest.approx((low, high), abs=1e-4)


def test_the_parameter_that_matters_comes_first() -> None:
    rows = [row(i, docked=i % 5 != 0) for i in range(200)]  # docks unless the camera's rate is 0
    first, *others = influences(rows)
    assert first.parameter == "simulator/camera/rate"
    assert [(group.label, group.docked) for group in first.groups][:2] == [("0", 0), ("1", 40)]
    assert first.evidence > 40.0 > max(other.evidence for other in others)
    lag = next(influence for influence in others if influence.parameter == "simulator/plant/lag_v")
    assert sum(group.runs for group in lag.groups) == 200 and len(lag.groups) == 6


def test_the_summary_counts_and_groups_texts_that_differ_in_numbers() -> None:
    summary = summarize([*ROWS, row(40, docked=False, touched=True), row(41, docked=False, at_rest=False)])
    assert (summary["runs"], summary["docked"], summary["touched"], summary["moving_at_the_end"]) == (42, 38, 1, 1)
    assert {"result": "MARKER_LOST", "text": "no marker seen for # m and # s", "runs": 3} in summary["results"]
    assert summary["of_docked"]["true heading error, absolute [deg]"]["max"] == pytest.approx(0.1)
    assert summary["realtime_factor"] == pytest.approx(2.5)
    assert summary["share_of_time"]["render"] == pytest.approx(0.5)


def test_bars_are_those_of_the_file() -> None:
    assert all_met(campaign_bars(summarize(ROWS), LIMITS))
    assert not all_met(campaign_bars(summarize(ROWS), LIMITS | {"docked": 0.96}))
    assert not all_met(campaign_bars(summarize([*ROWS, row(40, touched=True)]), LIMITS))
    assert not all_met(campaign_bars(summarize([*ROWS, row(40, at_rest=False)]), LIMITS))
    assert not all_met(campaign_bars(summarize([crashed(0)]), LIMITS))


def test_the_worst_come_first() -> None:
    rows = [row(1), row(2, docked=False), row(3, touched=True), crashed(4), row(5, position_error_m=0.009)]
    assert [r["index"] for r in worst(rows, 4)] == [3, 4, 2, 5]


def test_tables_have_a_line_for_every_run(tmp_path: Path) -> None:
    path, *_ = write_tables(tmp_path, "table", ROWS)
    lines = list(csv.DictReader(path.open(newline="")))
    assert len(lines) == 40 and "path" not in lines[0]
    assert (lines[7]["axis.dock"], float(lines[7]["simulator/plant/lag_v"])) == ("wide", 0.07)
    assert float(lines[7]["start_y_m"]) == 0.07
    assert lines[39]["result"] == "CRASHED" and lines[39]["position_error_m"] == ""


def test_parquet_holds_the_same_where_pyarrow_is_installed(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    _, path = write_tables(tmp_path, "table", ROWS)
    assert parquet.read_table(path).to_pylist()[3]["position_error_m"] == flat(ROWS[3])["position_error_m"]


def plan(shard: str = "1/1", seed: int = 1) -> Plan:
    return Plan.make(CONFIG, "default", "defaults", seed, 40, Shard.parse(shard))


class Resources(HTMLParser):
    """What a page refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found += [str(value) for name, value in attributes if name in ("src", "href", "data", "poster")]
        assert tag not in ("script", "link", "iframe")


def test_the_page_needs_nothing_but_itself(tmp_path: Path) -> None:
    data = campaign_data(plan(), ROWS)
    runs = [(entry, "") for entry in worst(ROWS, 2)]
    text = write_page(tmp_path / "page.html", data, bars_of(data), plan().dock(), runs).read_text()
    resources = Resources()
    resources.feed(text)
    assert len(resources.found) == 3 and all(value.startswith("data:image/") for value in resources.found)
    assert not re.search(r"@import|url\(", text)
    for part in ("38 of 40 docked", "the lens fell off", "&lt;most recent", "--replay seed:3", "MARKER_LOST"):
        assert part in text
    assert "38 of 40 docked" in describe(data)


def test_a_page_of_a_single_crash_can_be_written(tmp_path: Path) -> None:
    data = campaign_data(plan(), [crashed(0)])
    path = write_page(tmp_path / "page.html", data, bars_of(data), plan().dock(), [(data["rows"][0], "")])
    assert "0 of 1 docked" in path.read_text() and "0 of 1 docked" in describe(data)


def write_shards(folder: Path, **seeds: int) -> None:
    for number, shard in enumerate(("1/3", "2/3", "3/3")):
        data = campaign_data(plan(shard, seeds.get(f"s{number}", 1)), ROWS[number::3])
        write_results(folder / f"node{number % 2}", file_name(data), data, [])


def test_shards_become_the_whole(tmp_path: Path) -> None:
    write_shards(tmp_path)
    data = merge([tmp_path / "node0", tmp_path / "node1"])
    assert [r["index"] for r in data["rows"]] == list(range(40))
    whole = json.loads(json.dumps(campaign_data(plan(), ROWS)))
    assert data == whole and file_name(data) == "docking_campaign"


def test_what_does_not_belong_together_is_not_merged(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"no docking_campaign_I_of_N\.json"):
        merge([tmp_path])
    write_shards(tmp_path, s1=2)
    with pytest.raises(ParameterError, match=r"another campaign than .*: seed, key differ"):
        merge([tmp_path / "node0", tmp_path / "node1"])
    write_shards(tmp_path)
    with pytest.raises(ParameterError, match="13 cases are missing: 1, 4, "):
        merge([tmp_path / "node0"])
    with pytest.raises(ParameterError, match="cases are there twice"):
        merge([tmp_path / "node0", tmp_path / "node1", tmp_path / "node0"])
