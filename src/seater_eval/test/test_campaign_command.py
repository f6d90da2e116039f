"""The command from the outside: files, exit codes, replay; a dead process costs one run; Dask is optional."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml
from campaign_plans import CONFIG, FEW_IMAGES, load
from mortal_jobs import square_or_die

from seater_common.command.ending import ended
from seater_common.params import ParameterError
from seater_eval.campaign.command import main
from seater_eval.campaign.dask_cluster import over_dask
from seater_eval.campaign.processes import over_processes


def run(folder: Path, *arguments: str) -> int:
    plan = folder / "plan" / "near.yaml"  # beside the results, of which `merge` takes only those of campaigns
    plan.parent.mkdir(parents=True, exist_ok=True)
    near = load("kinematic")
    plan.write_text(yaml.safe_dump({**near, "axes": {**near["axes"], "images": FEW_IMAGES}}))
    words = ["--config", str(CONFIG), "--results", str(folder), "--campaign", str(plan), *arguments]
    return ended("docking_campaign", lambda: main("", words))


def test_two_shards_merged_are_the_campaign_and_a_case_can_be_replayed(
    tmp_path: Path, capsys: Any, monkeypatch: Any
) -> None:
    for shard in ("1/2", "2/2"):
        with monkeypatch.context() as patch:  # the merged page is drawn
            patch.setattr("seater_eval.campaign.command.write_page", lambda path, *_: path)
            assert run(tmp_path, "--runs", "2", "--no-images", "--shard", shard, "--workers", "1") in (0, 1)
    assert run(tmp_path / "all", "merge", str(tmp_path), "--figures", "0") in (0, 1)
    names = {path.name for path in (tmp_path / "all").iterdir()}
    assert {"docking_campaign.json", "docking_campaign.csv", "docking_campaign.html"} <= names
    first, second = json.loads((tmp_path / "all" / "docking_campaign.json").read_text())["rows"]
    assert (first["index"], second["index"]) == (0, 1) and first["docked"] and second["docked"]
    capsys.readouterr()
    assert run(tmp_path, "--no-images", "--replay", "1") == 0
    said = capsys.readouterr().out
    assert f"position_error_m: {second['position_error_m']}" in said
    assert (tmp_path / "docking_campaign_case_1.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    "arguments",
    [
        ["--campaign", "nowhere"],
        ["--shard", "3/2"],
        ["--axes", "plant,colour"],
        ["--replay", "first"],
        ["merge", "/nonexistent"],
    ],
)
def test_wrong_arguments_end_with_2_and_a_line(
    arguments: list[str], tmp_path: Path, capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert run(tmp_path, *arguments) == 2
    assert capsys.readouterr().err.startswith("docking_campaign: ")


@pytest.mark.parametrize("arguments", [["--runs", "0"], ["--workers", "0"], ["marge", "x"], ["merge"]])
def test_impossible_options_are_refused(arguments: list[str], tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as ended:
        run(tmp_path, *arguments)
    assert ended.value.code == 2


def test_a_process_that_dies_costs_its_own_result_alone() -> None:
    spread = over_processes(2, lambda job: -job)
    results = dict(spread(square_or_die, list(enumerate(range(9)))))
    assert results == {i: (-4 if i == 4 else i * i) for i in range(9)}


def test_without_dask_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ParameterError, match=r"needs Dask.*requirements_campaign\.txt"):
        over_dask("tcp://localhost:1", lambda job: job)


class KilledWorkerError(Exception):
    pass


class FakeClient:
    """What is used of a Dask client, in this process."""

    loop = None

    def __init__(self, address: str, **options: Any) -> None:
        if address != "tcp://here:1":
            raise OSError("timed out")

    def submit(self, function: Any, job: int, pure: bool) -> SimpleNamespace:
        assert not pure

        def result() -> int:
            if job == 2:
                raise KilledWorkerError
            return function(job)

        return SimpleNamespace(result=result, __hash__=None)

    def cancel(self, futures: list[Any]) -> None:
        assert futures == []

    def close(self) -> None:
        pass


def test_jobs_go_over_a_dask_cluster(monkeypatch: pytest.MonkeyPatch) -> None:
    class Future(SimpleNamespace):
        __hash__ = object.__hash__

    monkeypatch.setattr(sys.modules[__name__], "SimpleNamespace", Future)
    fake = SimpleNamespace(Client=FakeClient, KilledWorker=KilledWorkerError, as_completed=lambda f, loop: reversed(f))
    monkeypatch.setitem(sys.modules, "distributed", fake)
    spread = over_dask("tcp://here:1", lambda job: -job)
    assert dict(spread(square_or_die, [(10, 1), (11, 2), (12, 3)])) == {10: 1, 11: -2, 12: 9}
    with pytest.raises(ParameterError, match="no Dask scheduler at 'tcp://there:1': timed out"):
        over_dask("tcp://there:1", lambda job: job)
