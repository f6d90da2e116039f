"""The page of hazards names only tests, rows and codes that there are, and leaves no fault without an answer."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "explanation" / "hazards.md"
FEWEST = 60  # faults
ENTRY = re.compile(r"^(\d+)\. (.*(?:\n {3,}\S.*)*)", re.MULTILINE)
CODE = re.compile(r"\b[A-Z][A-Z_]{3,}\b")


def entries() -> dict[int, str]:
    """The faults by their number, each as one line."""
    return {int(number): re.sub(r"\s+", " ", text) for number, text in ENTRY.findall(PAGE.read_text())}


def table(title: str) -> list[list[str]]:
    """Rows of the table below a heading, without its head."""
    section = PAGE.read_text().split(f"\n## {title}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in section.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in row] for row in rows[2:]]


def numbers(text: str) -> set[int]:
    """Those of "1-3, 7; of the base"."""
    found = re.findall(r"(\d+)(?:-(\d+))?", text.split(";")[0])
    return {n for first, last in found for n in range(int(first), int(last or first) + 1)}


@cache
def python_functions() -> set[str]:
    files = [*ROOT.glob("src/*/test/**/test_*.py"), *ROOT.glob("test/**/*.py")]
    trees = [ast.parse(path.read_text()) for path in files]
    return {node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


@cache
def cpp_tests() -> set[str]:
    text = "".join(path.read_text() for path in ROOT.glob("src/*/test/**/*.cpp"))
    return {f"{suite}.{name}" for suite, name in re.findall(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)", text, re.MULTILINE)}


@cache
def fault_rows() -> set[str]:
    """Names of the cases of fault_table."""
    tree = ast.parse((ROOT / "src/seater_eval/src/seater_eval/faults/cases.py").read_text())
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
    return {call.args[0].value for call in calls if call.func.id == "_case"}  # type: ignore[attr-defined,union-attr]


@cache
def codes() -> set[str]:
    """Result codes, states of the gate, outcomes of an image."""
    messages = ("action/Dock.action", "msg/GateState.msg", "msg/DockInnovation.msg")
    text = "".join((ROOT / "src/seater_msgs" / name).read_text() for name in messages)
    return set(re.findall(r"^u?int\d+ ([A-Z_]+) ?=", text, re.MULTILINE))


def proof_exists(proof: str, row: bool) -> bool:
    if row:
        return proof in fault_rows()
    if proof.endswith(".test"):
        return (ROOT / "test" / "launch" / proof).is_file()
    return proof in (python_functions() if proof.startswith("test_") else cpp_tests())


def test_faults_are_numbered_one_after_the_other_and_many() -> None:
    assert list(entries()) == list(range(1, len(entries()) + 1))
    assert len(entries()) >= FEWEST


@pytest.mark.parametrize("number", entries())
def test_what_is_named_exists(number: int) -> None:
    text = entries()[number]
    named = [(bool(row), proof) for row, proof in re.findall(r"([Rr]ow )?`([^`]+)`", text)]
    assert [proof for row, proof in named if not proof_exists(proof, row)] == []
    assert set(CODE.findall(re.sub(r"`[^`]*`", "", text))) - codes() == set()
    assert named or "**Open**" in text or "**open**" in text, "neither shown nor open"


def test_whatever_else_is_named_exists() -> None:
    named = re.findall(r"`(test_\w+|\w+\.test)`", PAGE.read_text())
    assert [proof for proof in named if not proof_exists(proof, row=False)] == []


def test_every_row_of_the_fault_table_is_among_them() -> None:
    named = set(re.findall(r"[Rr]ow `([^`]+)`", " ".join(entries().values())))
    assert fault_rows() - named == set()


def test_every_fault_is_the_cause_of_a_hazard_with_a_class() -> None:
    classes = {row[0] for row in table("Severity")}
    hazards = table("Hazards")
    assert {row[2] for row in hazards} <= classes
    assert set().union(*(numbers(row[3]) for row in hazards)) == set(entries())


def test_clauses_name_faults_that_there_are() -> None:
    assert set().union(*(numbers(row[1]) for row in table("ISO 7176-14"))) <= set(entries())
