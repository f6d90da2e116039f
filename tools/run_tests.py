#!/usr/bin/env python3
"""Run the tests of the built workspace: gtest, pytest, rostest, evaluation commands, catkin_lint, ruff, mypy, clang-format.

Checks that do not depend on how quick the machine is share its cores; what measures time or lives by the clock on the
wall, or takes all cores by itself, runs alone afterwards. Ends with one line `N passed, N failed`, with `, N skipped`
where tests were skipped. Details are in results/test.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUTPUT = ROOT / "results" / "test"
LONGEST = 1200  # [s] of one command
EVALUATIONS = (
    "docking_table", "solver_benchmark", "controller_campaign", "perception_accuracy", "perception_range",
    "perception_shadows", "perception_speed",
)  # fmt: skip
# Send images at the pace of the clock on the wall, and wait a while for what must not come.
PACED = ("bad_images", "camera_moves")
# Bars that the data cannot decide (docs/perception_evaluation.md says why): missed, they count as skipped, not as failed.
UNDECIDABLE = {"visp-images-data: worst position error / best of OpenCV's refinements"}


@dataclass
class Tally:
    """Counts and what went wrong."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)  # for the screen

    def add(self, other: Tally) -> None:
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.problems += other.problems
        self.notes += other.notes

    def __str__(self) -> str:
        return f"{self.passed} passed, {self.failed} failed" + (f", {self.skipped} skipped" if self.skipped else "")


@dataclass
class Check:
    """What runs as one piece and has no need of the others."""

    name: str
    run: Callable[[], Tally]
    alone: bool = False  # depends on how quick the machine is, or takes all cores by itself


def command(name: str, words: list[str], **environment: str) -> tuple[int, Path]:
    """Runs it with its output in a file; returns exit code and file."""
    log = OUTPUT / f"{name}.log"
    with log.open("wb") as out:
        try:
            run = subprocess.run(
                words, cwd=ROOT, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=LONGEST,
                env={**os.environ, **environment},
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return 124, log
    return run.returncode, log


def tail(log: Path, lines: int = 40) -> str:
    return "\n".join(log.read_text(errors="replace").splitlines()[-lines:])


def exit_code(name: str, words: list[str], **environment: str) -> Tally:
    """A command whose exit code is the test."""
    code, log = command(name, words, **environment)
    if code == 0:
        return Tally(passed=1)
    return Tally(failed=1, problems=[f"{name}: exit code {code}\n{tail(log)}"])


def by_exit_code(name: str, words: list[str], **environment: str) -> Check:
    return Check(name, partial(exit_code, name, words, **environment))


def cases_of(report: Path) -> list[ElementTree.Element]:
    """The test cases of a JUnit file; none when a crash left it half written."""
    try:
        return list(ElementTree.parse(report).getroot().iter("testcase"))
    except ElementTree.ParseError:
        return []


def junit(name: str, words: list[str], report: Path, **environment: str) -> Tally:
    """Runs it and counts the cases of the JUnit file that it writes; a crash without one is a failure."""
    report.unlink(missing_ok=True)
    code, log = command(name, words, **environment)
    tally = Tally()
    if report.exists() and report.stat().st_size > 0:
        for case in cases_of(report):
            wrong = [element for element in case if element.tag in ("failure", "error")]
            if wrong:
                tally.failed += 1
                text = wrong[0].text or wrong[0].get("message") or ""
                tally.problems.append(f"{name}: {case.get('classname')}.{case.get('name')}\n{text.strip()[-3000:]}")
            elif case.find("skipped") is not None or case.get("status") == "notrun" or case.get("result") == "skipped":
                tally.skipped += 1
                tally.notes.append(f"skipped: {case.get('classname')}.{case.get('name')}")
            else:
                tally.passed += 1
    if code != 0 and tally.failed == 0:
        tally.failed += 1
        tally.problems.append(f"{name}: exit code {code}\n{tail(log)}")
    if code == 0 and tally.passed + tally.failed + tally.skipped == 0:
        tally.failed += 1
        tally.problems.append(f"{name}: ran no test\n{tail(log)}")
    return tally


def gtests() -> Iterator[Check]:
    programs = sorted(p for p in (ROOT / "build" / "devel" / "lib").glob("*/*_test") if os.access(p, os.X_OK))
    if not programs:
        yield Check("gtest", lambda: Tally(failed=1, problems=["gtest: no test program was built"]))
    for program in programs:
        report = OUTPUT / f"{program.name}.xml"
        words = [str(program), f"--gtest_output=xml:{report}"]
        yield Check(program.name, partial(junit, program.name, words, report))


def pytests() -> Iterator[Check]:
    """One run for each package: their test modules and conftest files may bear the same names."""
    folders = [f for f in sorted(ROOT.glob("src/*/test")) if any(f.glob("test_*.py"))]
    for folder in [*folders, ROOT / "test" / "structure"]:
        name = f"pytest_{folder.parent.name}"
        report = OUTPUT / f"{name}.xml"
        words = [sys.executable, "-m", "pytest", f"--junitxml={report}", str(folder.relative_to(ROOT))]
        yield Check(name, partial(junit, name, words, report))


def rostests() -> Iterator[Check]:
    for launch in sorted((ROOT / "test" / "launch").glob("*.test")):
        yield rostest(launch)


def rostest(launch: Path) -> Check:
    base = OUTPUT / "rostest"
    report = base / "seater_test" / f"rosunit-{launch.stem}.xml"  # with every case of the script
    words = ["rostest", "--results-base-dir", str(base), "--results-filename", f"{launch.stem}.xml", str(launch)]
    name = f"rostest_{launch.stem}"
    run = partial(junit, name, words, report, ROS_LOG_DIR=str(OUTPUT / "ros" / launch.stem))
    return Check(name, run, alone=launch.stem in PACED)


def packages() -> list[Path]:
    return sorted(p.parent for folder in ("src/*", "config", "test") for p in ROOT.glob(f"{folder}/package.xml"))


def lint() -> Iterator[Check]:
    for package in packages():
        words = ["catkin_lint", "-W2", "--strict", str(package)]
        if package.parent == ROOT:  # config/ and test/ are named for people who look into the repository
            words += ["--ignore", "package_path_name"]
        yield by_exit_code(f"catkin_lint_{package.name}", words)
    yield by_exit_code("ruff_check", ["ruff", "check", "."])
    yield by_exit_code("ruff_format", ["ruff", "format", "--check", "."])
    sources = [p / "src" for p in packages() if (p / "src" / p.name.replace("test", "seater_test")).is_dir()]
    path = ":".join(str(s) for s in sources)
    yield by_exit_code("mypy", ["mypy", *(str(s) for s in sources)], MYPYPATH=path)
    cpp = sorted(str(f) for end in ("h", "cpp") for f in ROOT.glob(f"src/**/*.{end}"))
    yield by_exit_code("clang_format", ["clang-format", "--dry-run", "--Werror", *cpp])


def install_space() -> Iterator[Check]:
    """`cmake --install`, then one docking from there with nothing of the build sourced."""
    yield by_exit_code("install_space", ["bash", "test/install_space.sh", str(ROOT)])


def evaluations() -> Iterator[Check]:
    """The evaluation commands' small versions: each bar counts as a test."""
    for name in EVALUATIONS:
        yield Check(name, partial(evaluation, name), alone=True)


def evaluation(name: str) -> Tally:
    report = OUTPUT / "evaluation" / f"{name}.json"
    report.unlink(missing_ok=True)
    words = ["rosrun", "seater_eval", name, "--quick", "--results", str(report.parent), "--config", "config"]
    code, log = command(name, words)
    bars = json.loads(report.read_text())["bars"] if report.exists() else []
    missed = [bar for bar in bars if not bar["met"]]
    wrong = [bar for bar in missed if bar["name"] not in UNDECIDABLE or bar["value"] is None]
    tally = Tally(len(bars) - len(missed), len(wrong), len(missed) - len(wrong), [f"{name}: {bar}" for bar in wrong])
    for bar in missed:
        if bar not in wrong:
            tally.notes.append(f"not met, undecidable: {bar['name']}: {bar['value']:.3g}, limit {bar['limit']:g}")
    if not bars or (code != 0) != bool(missed):
        tally.add(Tally(failed=1, problems=[f"{name}: exit code {code}, {len(missed)} bars missed\n{tail(log)}"]))
    return tally


STAGES: dict[str, Callable[[], Iterator[Check]]] = {
    "lint": lint,
    "gtest": gtests,
    "pytest": pytests,
    "install": install_space,
    "rostest": rostests,
    "evaluation": evaluations,
}


def timed(check: Check) -> Tally:
    """Runs it and says what came out."""
    started = time.monotonic()
    try:
        tally = check.run()
    except (OSError, ValueError, KeyError) as error:  # a program that is not there, a report that cannot be read
        tally = Tally(failed=1, problems=[f"{check.name}: {error!r}"])
    for note in tally.notes:
        print(f"  {check.name}: {note}", flush=True)
    print(f"  {check.name}: {tally} ({time.monotonic() - started:.0f} s)", flush=True)
    return tally


def run_all(checks: list[Check], jobs: int) -> Tally:
    total = Tally()
    with ThreadPoolExecutor(jobs) as pool:
        for tally in pool.map(timed, [check for check in checks if not check.alone]):
            total.add(tally)
    for check in checks:
        if check.alone:
            total.add(timed(check))
    return total


def main() -> int:
    parser = argparse.ArgumentParser(prog="seater test", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    parser.add_argument("--only", nargs="+", choices=list(STAGES), help="only these stages")
    parser.add_argument("--rostest", nargs="+", metavar="NAME", help="only these files of test/launch, e.g. cancel")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, metavar="N",
                        help="checks at the same time (default: %(default)s, one a core)")  # fmt: skip
    options = parser.parse_args()
    OUTPUT.mkdir(parents=True, exist_ok=True)
    if options.rostest:
        checks = [rostest(ROOT / "test" / "launch" / f"{name}.test") for name in options.rostest]
    else:
        checks = [check for name in options.only or STAGES for check in STAGES[name]()]
    total = run_all(checks, max(1, options.jobs))
    for problem in total.problems:
        print(f"\nFAILED {problem}")
    print(f"\n{total}")
    return 0 if total.failed == 0 and total.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
