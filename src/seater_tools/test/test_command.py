"""`./seater sheets` as a person types it."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from as_typed import Done
from as_typed import run as run_program
from printed import DEFAULT_DOCK


def run(folder: Path, *words: str | Path) -> Done:
    return run_program("sheets", "--results", folder, *words)


def test_a_pdf_for_each_dock_file(tmp_path: Path) -> None:
    other = tmp_path / "big.yaml"
    other.write_text(DEFAULT_DOCK.read_text().replace("size: 0.100", "size: 0.300"))
    done = run(tmp_path / "out", "--dock", DEFAULT_DOCK, other)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["big_a4.pdf", "default_a4.pdf"]
    assert "page 3: marker 0, 100 mm" in done.stdout
    assert "pages 3-8: marker 0, 300 mm" in done.stdout
    assert "bar not 190 mm long?" in done.stdout


def test_a_measured_bar_gives_a_copy_and_overwrites_nothing(tmp_path: Path) -> None:
    first = run(tmp_path, "--dock", DEFAULT_DOCK, "--measured-bar", "188.1")
    assert first.returncode == 0, first.stderr
    assert "scale is 99.00 %" in first.stdout and "marker 1: 150.00 -> 148.50 mm" in first.stdout
    copy = (tmp_path / "default.yaml").read_text()
    assert "size: 0.1485" in copy
    again = run(tmp_path, "--dock", DEFAULT_DOCK, "--measured-bar", "189.5")
    assert again.returncode == 1 and "exists already; --force overwrites it" in again.stderr
    assert (tmp_path / "default.yaml").read_text() == copy
    assert run(tmp_path, "--dock", DEFAULT_DOCK, "--measured-bar", "189.5", "--force").returncode == 0
    assert (tmp_path / "default.yaml").read_text() != copy
    printed = run(tmp_path, "--dock", tmp_path / "default.yaml")
    assert printed.returncode == 2 and "sizes are corrected for a print" in printed.stderr


@pytest.mark.parametrize(
    ("old", "new", "words", "problem"),
    [
        ("size: 0.100", "size: 0.0", (), "dock.yaml/markers[0]/size: is 0.0, must be >= 0.005"),
        ("id: 2", "id: 77", (), "dock.yaml/markers[2]/id: is 77, must be 0 to 49 (DICT_4X4_50)"),
        ("DICT_4X4_50", "DICT_9X9", (), "dictionary: is 'DICT_9X9', must be one of"),
        ("predock_x", "predok_x", (), "dock.yaml/predok_x: unknown key"),
        ("", "", ("--measured-bar", "100"), "--measured-bar: is 100 mm, must be 152 to 237.5 mm"),
        ("", "", ("--measured-bar", "1", "2", "3"), "--measured-bar: has more than two numbers"),
        ("", "", ("--paper", "a9"), "--paper: invalid choice"),
        ("size: 0.100", "size: 0.005", ("--measured-bar", "180"), "dock.yaml/markers[0]/size: is 0.00474, must be >="),
    ],
)
def test_errors_name_the_key(tmp_path: Path, old: str, new: str, words: tuple[str, ...], problem: str) -> None:
    dock = tmp_path / "dock.yaml"
    dock.write_text(DEFAULT_DOCK.read_text().replace(old, new) if old else DEFAULT_DOCK.read_text())
    done = run(tmp_path / "out", "--dock", dock, *words)
    assert done.returncode == 2
    assert problem in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_copy_never_takes_the_place_of_its_original(tmp_path: Path) -> None:
    dock = tmp_path / "dock.yaml"
    dock.write_text(DEFAULT_DOCK.read_text())
    done = run(tmp_path, "--dock", dock, "--measured-bar", "188", "--force")
    assert done.returncode == 2 and "holds the dock file itself" in done.stderr
    assert dock.read_text() == DEFAULT_DOCK.read_text()
    twice = run(tmp_path, "--dock", dock, tmp_path / ".." / tmp_path.name / "dock.yaml")
    assert twice.returncode == 2 and "several files have the name dock" in twice.stderr


def test_the_sheets_of_an_installation_name_it(tmp_path: Path) -> None:
    """The pages say what to type when the printer's scale is off; that has to correct the installation's own file."""
    assert run_program("installation", tmp_path).returncode == 0
    done = run_program("sheets", "--installation", tmp_path)
    assert done.returncode == 0 and "\nNext: ./seater sheets --board charuco" in done.stdout
    pages = subprocess.run(["pdftotext", tmp_path / "sheets" / "dock_a4.pdf", "-"], capture_output=True, text=True)
    assert f"./seater sheets --installation {tmp_path}" in pages.stdout and "--dock" not in pages.stdout
    assert run_program("sheets", "--installation", tmp_path, "--measured-bar", "188.1").returncode == 0
    assert (tmp_path / "dock.yaml").read_text().startswith("# Sizes of the markers as printed: 99.00 %")
