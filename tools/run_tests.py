#!/usr/bin/env python3
"""Run the tests of the built workspace with CTest and add up their cases; ends with one line `N passed, N failed`.

Every test is registered with CMake by the package that it belongs to (gtest, pytest, rostest, evaluation, lint,
install), so `ctest --test-dir build` runs the same. This program chooses, shows progress, and sums the cases of all
JUnit files. Tests share the cores; what has to keep the pace of the clock on the wall begins first, then the longest
(COST). Output of each test: build/Testing/Temporary/LastTest.log; JUnit files and figures: build/test_results.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LONGEST = 900  # [s] of one test
KINDS = ("lint", "gtest", "pytest", "install", "rostest", "evaluation")
CATKIN_NAME = re.compile(r"_ctest_(?P<package>\w+?)_(?P<kind>gtest|pytest|rostest|evaluation)_(?P<name>.+)")


@dataclass
class Tally:
    """Cases, and what went wrong."""

    passed: int = 0
    failed: int = 0
    skipped: int = 0
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped
        self.problems += other.problems
        self.notes += other.notes

    def __str__(self) -> str:
        return f"{self.passed} passed, {self.failed} failed" + (f", {self.skipped} skipped" if self.skipped else "")


@dataclass(frozen=True)
class Test:
    """One entry of CTest's report."""

    name: str
    seconds: float
    passed: bool
    output: str

    @property
    def kind(self) -> str:
        """One of KINDS."""
        match = CATKIN_NAME.fullmatch(self.name)
        return match["kind"] if match else self.name.partition("_")[0]

    def junit_file(self, results: Path) -> Path | None:
        """The file in the folder of results that holds every case; None for a test that is its exit code."""
        match = CATKIN_NAME.fullmatch(self.name)
        if match is None:
            return None
        folder, name = results / match["package"], match["name"]
        if match["kind"] == "rostest":
            return folder / f"rosunit-{name.removeprefix('launch_').removesuffix('.test')}.xml"
        if match["kind"] == "pytest":
            return folder / ("pytest.xml" if name == match["package"] else f"pytest-{name}.xml")
        return folder / f"{match['kind']}-{name}.xml"


def count_cases(junit: Path) -> Tally:
    """The cases of a JUnit file; none when it is not there or a crash left it half written."""
    try:
        cases = list(ElementTree.parse(junit).getroot().iter("testcase"))
    except (OSError, ElementTree.ParseError):
        return Tally()
    tally = Tally()
    for case in cases:
        name = f"{case.get('classname')}.{case.get('name')}"
        wrong = [element for element in case if element.tag in ("failure", "error")]
        if wrong:
            tally.failed += 1
            text = wrong[0].text or wrong[0].get("message") or ""
            tally.problems.append(f"{name}\n{text.strip()[-3000:]}")
        elif case.find("skipped") is not None or case.get("status") == "notrun" or case.get("result") == "skipped":
            tally.skipped += 1
            reason = case.find("skipped")
            tally.notes.append(f"skipped: {name} {'' if reason is None else reason.get('message') or ''}".rstrip())
        else:
            tally.passed += 1
    return tally


def tally_of(test: Test, results: Path) -> Tally:
    """Cases of one test; a failure that no case shows counts as one, and so does a passed test without a case."""
    junit = test.junit_file(results)
    if junit is None:
        return Tally(passed=1) if test.passed else Tally(failed=1, problems=[f"{test.name}\n{tail(test.output)}"])
    tally = count_cases(junit)
    if (not test.passed and tally.failed == 0) or tally.passed + tally.failed + tally.skipped == 0:
        tally.failed += 1
        tally.problems.append(f"{test.name}: ended badly, or without a case\n{tail(test.output)}")
    return tally


def tail(text: str, lines: int = 40) -> str:
    return "\n".join(text.splitlines()[-lines:])


def read_report(report: Path) -> list[Test]:
    """CTest's own JUnit report."""
    cases = ElementTree.parse(report).getroot().iter("testcase")
    return [
        Test(
            case.get("name", ""),
            float(case.get("time", "0")),
            case.get("status") == "run",
            case.findtext("system-out", ""),
        )
        for case in cases
    ]


def ctest_command(options: argparse.Namespace, report: Path) -> list[str]:
    words = ["ctest", "--test-dir", str(options.build), "-j", str(max(1, options.jobs)), "--timeout", str(LONGEST)]
    words += ["-C", "extensive"] if options.all else []
    words += ["--output-junit", str(report), "--no-tests=error"]
    if options.rostest:
        wanted = [f"rostest_launch_{re.escape(name)}\\.test$" for name in options.rostest]
    elif options.match:
        wanted = [options.match]
    else:
        wanted = [of_kind(kind) for kind in options.only or []]
    others = [of_kind(kind) for kind in KINDS if options.match and options.only and kind not in options.only]
    words += ["-R", "|".join(wanted)] if wanted else []
    return [*words, "-E", "|".join(others)] if others else words


def of_kind(kind: str) -> str:
    """What the names of its tests match."""
    return f"^{kind}|_{kind}_"


def describe_times(tests: list[Test]) -> str:
    """Where the time went: the sum of each kind, and the longest tests."""
    sums: dict[str, float] = defaultdict(float)
    for test in tests:
        sums[test.kind] += test.seconds
    kinds = ", ".join(f"{kind} {sums[kind]:.0f} s" for kind in KINDS if kind in sums)
    longest = sorted(tests, key=lambda test: -test.seconds)[:8]
    return f"time of all tests, added up: {kinds}\nlongest: " + ", ".join(
        f"{test.name.removeprefix('_ctest_')} {test.seconds:.0f} s" for test in longest
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="seater test", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)  # fmt: skip
    chosen = parser.add_mutually_exclusive_group()
    parser.add_argument("--only", nargs="+", choices=KINDS, help="only these kinds of tests")
    chosen.add_argument("--rostest", nargs="+", metavar="NAME",
                        help="these files of test/launch (--all: and of its extensive/), e.g. cancel")  # fmt: skip
    chosen.add_argument("--match", metavar="REGEX", help="only tests whose name matches, as `ctest -R`")
    parser.add_argument(
        "--all",
        action="store_true",
        help="also what takes many minutes: evaluations, more starts and values, clang-tidy",
    )
    # Two more than cores: tests with nodes wait a part of their time (a third of it, on two cores).
    parser.add_argument("--jobs", type=int, default=(os.cpu_count() or 1) + 2, metavar="N",
                        help="tests at the same time (default: %(default)s, two more than cores)")  # fmt: skip
    parser.add_argument("--build", type=Path, default=ROOT / "build", metavar="DIR",
                        help="build folder (default: build)")  # fmt: skip
    options = parser.parse_args()
    results = options.build / "test_results"
    report = results / "ctest.xml"
    results.mkdir(parents=True, exist_ok=True)
    report.unlink(missing_ok=True)
    code = subprocess.run(ctest_command(options, report), cwd=ROOT).returncode
    if not report.exists():
        print("seater test: ctest wrote no report; is there such a test?", file=sys.stderr)
        return code or 1
    tests, total = read_report(report), Tally()
    for test in tests:
        total.add(tally_of(test, results))
    for problem in total.problems:
        print(f"\nFAILED {problem}")
    print("\n" + "\n".join([*total.notes, describe_times(tests)]))
    print(f"\n{total}")
    return 0 if code == 0 and total.failed == 0 and total.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
