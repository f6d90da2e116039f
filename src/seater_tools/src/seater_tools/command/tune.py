"""Search better weights for this chair, over simulated dockings out of a campaign.

Score, lower is better: for each docking, c = time / time before + half of (jerk / jerk before + angular jerk / angular
jerk before) / 2; over all dockings, median(c) + half of (90th percentile of c - median). Allowed is only what docks as
often as before, touches nothing (not more than before), and whose final errors stay below half the dock's tolerance in
95 of 100 dockings (or where they were). Every trial drives the same dockings. The best one is compared with the file on
dockings that the search has not seen; only where these show it to be better, a copy of controller.yaml is written.
The original is never changed. Ctrl-C keeps what was found; the same command goes on from there.
Exit status: 0 better values were found, 1 nothing better was found, 2 wrong input, 130 interrupted.
"""

from __future__ import annotations

import argparse
import datetime
from collections.abc import Mapping
from pathlib import Path
from shlex import quote

from seater_common.command.ending import results_folder
from seater_common.files import installation
from seater_common.params import ParameterError, read_yaml
from seater_eval.run.long_run import exit_when_interrupted
from seater_eval.run.parallel import cores
from seater_tools.tune import report
from seater_tools.tune.compare import compare
from seater_tools.tune.dockings import ChairFiles, Dockings
from seater_tools.tune.objective import Measures, Verdict, judge
from seater_tools.tune.search import Search, Trial, best
from seater_tools.tune.space import Tunable, tunables

NOTHING_BETTER = 1
ROLES = {role: role for role in ("chair", "dock", "controller", "camera")}
_LOWEST = {"trials": 0, "jobs": 1, "cases": 2, "judge_cases": 2, "seed": 0}


def add_options(parser: argparse.ArgumentParser, config: Path) -> None:
    """`config`: folder of the default files."""
    parser.add_argument("--installation", type=Path, metavar="DIR",
                        help="tune for the files there; results go into DIR/tune, the files stay")  # fmt: skip
    parser.add_argument("--trials", type=int, default=100, help="in all, those of earlier runs among them (100)")
    parser.add_argument("--jobs", type=int, default=cores(), help="dockings at a time (one per core)")
    parser.add_argument("--cases", type=int, default=24, help="dockings per trial (24)")
    parser.add_argument("--judge-cases", type=int, default=60, help="other dockings for before and after (60)")
    parser.add_argument("--seed", type=int, default=1, help="of dockings and search (1)")
    parser.add_argument("--campaign", default="default", help="name in config/campaign, or a YAML file (default)")
    parser.add_argument("--images", action="store_true", help="out of rendered images: several times slower")
    parser.add_argument("--chair", type=Path, default=config / "chair.yaml")
    parser.add_argument("--dock", type=Path, default=config / "docks" / "default.yaml")
    parser.add_argument("--controller", type=Path, default=config / "controller.yaml")
    parser.add_argument("--camera", type=Path, help="the camera's calibration (d455.yaml)")
    parser.add_argument("--results", type=results_folder, default="results/tune", metavar="DIR", help="(results/tune)")


def parse(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """The options, checked; ends the program (2) where one is wrong."""
    options = parser.parse_args()
    for name, lowest in _LOWEST.items():
        if getattr(options, name) < lowest:
            parser.error(f"--{name.replace('_', '-')}: is {getattr(options, name)}, must be at least {lowest}")
    installation.use(options, parser, ROLES, "tune")
    return options


def run(options: argparse.Namespace, config: Path) -> int:
    """Raises ParameterError (wrong input) and OSError."""
    own = ChairFiles(chair=options.chair, dock=options.dock, controller=options.controller, camera=options.camera)
    target = options.results / "controller.yaml"
    if target.resolve() == options.controller.resolve():
        raise ParameterError(f"--results: {options.results} holds {target.name} itself; choose another folder")
    space = tunables(read_yaml(own.controller), str(own.controller))
    dockings = Dockings(
        config,
        own,
        campaign=options.campaign,
        seed=options.seed,
        cases=options.cases,
        images=options.images,
        jobs=options.jobs,
    )
    search = Search(options.results / "search.journal", space, options.seed, f"{dockings.key} {space}")
    with exit_when_interrupted(lambda: _kept(search, options)):
        _search(search, dockings, space, options.trials)
        return _conclude(search, dockings, space, options)


def _kept(search: Search, options: argparse.Namespace) -> str:
    return (
        f"{len(search.trials)} trials are kept in {options.results}; the same command goes on from there, and with "
        "--trials 0 it judges the best of them"
    )


def _search(search: Search, dockings: Dockings, space: list[Tunable], wanted: int) -> None:
    done = len(search.trials)
    if done:
        print(f"{done} trials are there already")
    if done >= wanted:
        return
    before = dockings.run({})
    print(f"before: {before.docked} of {len(before.time)} docked, {before.touched} touched", flush=True)
    if before.docked == 0:
        raise ParameterError("no docking of the campaign succeeds with the files as they are: nothing to compare with")
    as_it_is = {t.key: t.value for t in space}

    def evaluate(values: Mapping[str, float]) -> Verdict:
        found: Measures = before if dict(values) == as_it_is else dockings.run(values)
        return judge(found, before, dockings.tolerance)

    lowest: Trial | None = best(search.trials)
    for _ in range(done, wanted):
        trial = search.step(evaluate)
        lowest = best([trial] if lowest is None else [lowest, trial])
        print(report.line(trial, wanted, lowest), flush=True)


def _conclude(search: Search, dockings: Dockings, space: list[Tunable], options: argparse.Namespace) -> int:
    """Before against the best on other dockings; table, JSON, figure, copy."""
    trials = search.trials
    chosen, found = best(trials), None
    values = {} if chosen is None else chosen.values
    if chosen is not None and any(values[t.key] != t.value for t in space):
        held_out = dockings.held_out(options.judge_cases)
        print(f"comparing trial {chosen.number + 1} with the file on {options.judge_cases} other dockings", flush=True)
        found = compare(held_out.run({}), held_out.run(values), dockings.tolerance)
        print("\n" + report.describe(found, space, values) + "\n")
    conditions = {name: getattr(options, name) for name in ("campaign", "seed", "cases", "judge_cases", "images")}
    print(report.write(options.results / "tune.json", report.as_json(trials, space, found, conditions)))
    print(report.draw(options.results / "tune.png", trials, space, found))
    target = options.results / "controller.yaml"
    if found is None or not found.better:
        target.unlink(missing_ok=True)  # of an earlier, shorter search
        print("\nNothing better was found: keep the file as it is.")
        return NOTHING_BETTER
    note = f"{datetime.date.today()}, {len(trials)} trials of {options.cases} simulated dockings"
    text = report.tuned_text(options.controller.read_text(), str(options.controller), values, note)
    print(report.write(target, text.encode()))
    print(f"\nBetter values are in this copy. To use them: cp {quote(str(target))} {quote(str(options.controller))}")
    return 0
