"""The command docking_campaign: options, and what is done in which order."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from seater_common.params import ParameterError
from seater_eval.campaign.dask_cluster import over_dask
from seater_eval.campaign.drive.job import process_died, run_case
from seater_eval.campaign.plan import Plan, Shard
from seater_eval.campaign.processes import over_processes
from seater_eval.campaign.replay import replay_embedded, save_replay
from seater_eval.campaign.report.docking_figure import title
from seater_eval.campaign.report.figures import worst
from seater_eval.campaign.report.page import write_page
from seater_eval.campaign.report.table import write_tables
from seater_eval.campaign.report.text import describe
from seater_eval.campaign.results import COMMAND, bars_of, campaign_data, file_name, merge
from seater_eval.campaign.setup.told import CHOICES
from seater_eval.report.bars import conclude
from seater_eval.run.commands import config_folder, make_parser
from seater_eval.run.long_run import run_long
from seater_eval.run.parallel import Spread, cores

_EPILOGUE = f"""{COMMAND} merge FOLDER ... [--results FOLDER] makes one report of all shards in the folders.
docs/how-to/run_a_campaign.md explains campaign files, clusters and results."""


def parser(description: str | None) -> argparse.ArgumentParser:
    """All options."""
    made = make_parser(COMMAND, description)
    made.epilog = _EPILOGUE
    made.add_argument("merge", nargs="*", metavar="merge FOLDER", help="only merge the shards that lie there")
    made.add_argument("--campaign", default="default", help="name in config/campaign, or a YAML file (default)")
    made.add_argument(
        "--axes", default="", help="vary only these, e.g. dock,camera; others stay at their first variant"
    )
    made.add_argument("--runs", type=int, help="how many (default: 1000, with --quick 8)")
    made.add_argument("--seed", type=int, default=1, help="of all that is drawn (1)")
    made.add_argument("--told", default="defaults", choices=CHOICES, help="what the controller is given (defaults)")
    made.add_argument(
        "--minimum-time", action="store_true", help="compare with the shortest possible time (seconds a run)"
    )
    made.add_argument(
        "--no-images", action="store_true", help="draw poses of the dock with perception's error instead: much faster"
    )
    made.add_argument("--workers", type=int, help="processes on this machine (default: one a core)")
    made.add_argument("--shard", default="1/1", metavar="I/N", help="only every N-th case, beginning with the I-th")
    made.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask cluster, e.g. tcp://host:8786")
    made.add_argument("--figures", type=int, help="worst runs that are replayed for the page (6, with --quick 1)")
    made.add_argument("--replay", default="", metavar="CASE", help="one case again, by index or seed:NUMBER; a figure")
    return made


def main(description: str | None, arguments: Sequence[str] | None = None) -> int:
    """The exit code: 0 all bars met, 1 not. Raises ParameterError, OSError."""
    made = parser(description)
    options = made.parse_args(arguments)
    if options.merge and (options.merge[0] != "merge" or len(options.merge) < 2):
        made.error(f"unknown argument: {options.merge[0]}; did you mean: merge FOLDER ...")
    for name, lowest in (("runs", 1), ("workers", 1), ("figures", 0), ("seed", 0)):
        value = getattr(options, name)
        if value is not None and value < lowest:
            made.error(f"--{name}: is {value}, must be at least {lowest}")
    return _run(options)


def _run(options: argparse.Namespace) -> int:
    if options.merge:
        data = merge([Path(folder) for folder in options.merge[1:]])
        options.campaign, options.told, options.seed = data["name"], data["told"], data["seed"]
        options.axes, options.no_images = ",".join(data["axes_varied"]), not data["images"]
        return _report(options, _plan(options, data["runs"], Shard()), data)
    plan = _plan(options, options.runs or (8 if options.quick else 1000), Shard.parse(options.shard))
    if options.replay:
        return _replay(options, plan)
    rows = run_long(
        run_case,
        plan.jobs(),
        label=COMMAND,
        files=libraries(),
        partial=options.results / f"{file_name({'shard': str(plan.shard)})}.partial",
        inputs=(plan.key(), str(plan.shard)),  # with more runs of the same seed, it begins with the same ones
        spread=_spread(options),
    )
    return _report(options, plan, campaign_data(plan, rows))


def _plan(options: argparse.Namespace, runs: int, shard: Shard) -> Plan:
    axes = options.axes.split(",") if options.axes else []
    made = Plan.make(config_folder(options), options.campaign, options.told, options.seed, runs, shard, axes)
    return replace(made, bound=options.minimum_time, images=not options.no_images)


def _spread(options: argparse.Namespace) -> Spread:
    if options.scheduler:
        return over_dask(options.scheduler, process_died)
    return over_processes(options.workers or cores(), process_died)


def _replay(options: argparse.Namespace, plan: Plan) -> int:
    kind, _, number = options.replay.rpartition(":")
    if kind not in ("", "seed") or not number.isdecimal():
        raise ParameterError(f"--replay: is {options.replay!r}, must be an index or seed:NUMBER")
    job = plan.job_of_seed(int(number)) if kind else plan.job(int(number))
    row, path = save_replay(job, options.results / f"{COMMAND}_case_{kind}{number}.png")
    for key, value in row.items():
        if key not in ("path", "text"):
            print(f"  {key}: {value}")
    print(f"\n{title(row)}\n{row['text']}\n" + (f"  {path}" if path is not None else ""))
    return 0 if row["docked"] else 1


def _report(options: argparse.Namespace, plan: Plan, data: dict[str, Any]) -> int:
    print(describe(data))
    bars, name = bars_of(data), file_name(data)
    wanted = options.figures if options.figures is not None else (1 if options.quick else 6)
    jobs = [plan.job(row["index"]) for row in worst(data["rows"], wanted)] if plan.shard.of == 1 else []
    figures = dict(_spread_figures(options, jobs))
    pictured = [(row, figures[i]) for i, (row) in enumerate(worst(data["rows"], len(jobs)))]
    files = write_tables(options.results, name, data["rows"])
    files.append(write_page(options.results / f"{name}.html", data, bars, plan.dock(), pictured))
    return conclude(options.results, name, {"quick": options.quick, **data}, bars, files)


def _spread_figures(options: argparse.Namespace, jobs: Sequence[Any]) -> list[tuple[int, str]]:
    spread = over_processes(options.workers or cores(), lambda job: (process_died(job), ""))
    return [(index, image) for index, (_, image) in spread(replay_embedded, list(enumerate(jobs)))]


def libraries() -> list[Path]:
    """The files of perception library and gate as they are loaded in this process."""
    maps = Path("/proc/self/maps").read_text().splitlines()
    return sorted({Path(line.split()[-1]) for line in maps if "/" in line and "seater_" in line and ".so" in line})
