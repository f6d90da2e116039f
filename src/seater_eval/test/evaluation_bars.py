#!/usr/bin/env python3
"""Run the small version of one evaluation command and report each of its bars as a test case, in JUnit's form.

usage: evaluation_bars.py COMMAND FOLDER

Writes FOLDER/COMMAND.json (by the command itself), its figures, and FOLDER/evaluation-COMMAND.xml. Exits with 0 when
every bar is met or cannot be decided, and the command's own exit code says the same.
"""

from __future__ import annotations

import json
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

# Bars that the data cannot decide (docs say why): missed, they count as skipped, not as failed.
UNDECIDABLE = {"visp-images-data: worst position error / best of OpenCV's refinements"}


def bar_case(suite: ElementTree.Element, bar: dict[str, Any]) -> ElementTree.Element:
    """The bar as a test case of the suite; the problem, if any, is a child of the case."""
    case = ElementTree.SubElement(suite, "testcase", classname=suite.get("name", ""), name=bar["name"])
    text = f"{bar['value']}, {bar['sense']} {bar['limit']} {bar.get('unit', '')} {bar.get('note', '')}".rstrip()
    if not bar["met"]:
        undecidable = bar["name"] in UNDECIDABLE and bar["value"] is not None
        ElementTree.SubElement(case, "skipped" if undecidable else "failure", message=text)
    return case


def report(command: str, code: int, bars: list[dict[str, Any]]) -> ElementTree.Element:
    """The suite of all bars; a command that wrote none, or whose exit code contradicts its bars, is an error."""
    suite = ElementTree.Element("testsuite", name=f"evaluation.{command}")
    cases = [bar_case(suite, bar) for bar in bars]
    missed = sum(not bar["met"] for bar in bars)
    if not bars or (code != 0) != (missed > 0):
        ran = ElementTree.SubElement(suite, "testcase", classname=f"evaluation.{command}", name="runs")
        ElementTree.SubElement(ran, "error", message=f"exit code {code}, {len(bars)} bars, {missed} missed")
        cases.append(ran)
    for attribute, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(attribute, str(sum(case.find(tag) is not None for case in cases)))
    suite.set("tests", str(len(cases)))
    return suite


def main() -> int:
    command, folder = sys.argv[1], Path(sys.argv[2])
    results = folder / f"{command}.json"
    results.unlink(missing_ok=True)
    run = subprocess.run(["rosrun", "seater_eval", command, "--quick", "--results", str(folder)])
    bars = json.loads(results.read_text())["bars"] if results.exists() else []
    suite = report(command, run.returncode, bars)
    folder.mkdir(parents=True, exist_ok=True)
    ElementTree.ElementTree(suite).write(folder / f"evaluation-{command}.xml", encoding="utf-8", xml_declaration=True)
    return 0 if suite.get("failures") == suite.get("errors") == "0" else 1


if __name__ == "__main__":
    sys.exit(main())
